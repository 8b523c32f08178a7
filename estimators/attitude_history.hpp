// SPDX-License-Identifier: BSD-3-Clause
// The last attitudes with their stamps: what the attitude was, or will shortly be, at any moment asked for.
#pragma once

#include <array>
#include <cstdint>

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"

namespace sortie::estimators {

/// Ring of the newest attitudes, thinned to one per `spacing_ns`. 32 entries, 2.3 kB, no heap; a look-up
/// walks back from the newest, 32 steps at most.
class AttitudeHistory {
 public:
  static constexpr std::uint32_t kEntries = 32;

  /// Attitude and turn at one moment.
  struct Entry {
    rt::Nanoseconds stamp_ns{};
    rt::Quaternion q_world_body;
    rt::Vector3 w_body_rad_s;
    SORTIE_FIELDS(stamp_ns, q_world_body, w_body_rad_s)
  };

  /// Answer to a question: `exact` is false when the moment lay outside what is known by more than
  /// `max_extrapolation_ns` and the nearest known attitude was given. Ask it before the attitude is believed.
  struct Answer {
    rt::Quaternion q_world_body;
    bool exact{};
  };

  AttitudeHistory(rt::Nanoseconds spacing_ns, rt::Nanoseconds max_extrapolation_ns)
      : spacing_ns_(spacing_ns), max_extrapolation_ns_(max_extrapolation_ns) {}

  /// Adds an attitude newer than the newest; an older one clears the ring first (its clock was set anew).
  void add(const rt::AttitudeEstimate& attitude) {
    if (size_ > 0 && attitude.stamp_ns < back(0).stamp_ns) size_ = 0;
    const bool replace = size_ > 0 && (attitude.stamp_ns == back(0).stamp_ns ||
                                       (size_ > 1 && attitude.stamp_ns - back(1).stamp_ns < spacing_ns_));
    if (!replace) {
      newest_ = (newest_ + 1) % kEntries;
      size_ = size_ < kEntries ? size_ + 1 : kEntries;
    }
    entries_[newest_] = {attitude.stamp_ns, rt::to_quaternion(attitude.q_world_body),
                         rt::to_vector(attitude.w_body_rad_s)};
  }

  /// Number of attitudes held.
  std::uint32_t size() const { return size_; }
  /// The n-th newest; n < size().
  const Entry& back(std::uint32_t n) const { return entries_[(newest_ + kEntries - n) % kEntries]; }

  /// Attitude at `stamp_ns`: between neighbours, or turned on from the newest. Ask only when size() > 0.
  Answer at(rt::Nanoseconds stamp_ns) const {
    const Entry& newest = back(0);
    if (stamp_ns >= newest.stamp_ns) {
      const rt::Nanoseconds ahead_ns = stamp_ns - newest.stamp_ns;
      const bool near = ahead_ns <= max_extrapolation_ns_;
      const double ahead_s = rt::to_seconds(near ? ahead_ns : max_extrapolation_ns_);
      return {newest.q_world_body * exp_rotation(ahead_s * newest.w_body_rad_s), near};
    }
    for (std::uint32_t n = 1; n < size_; ++n) {
      const Entry& a = back(n);
      if (a.stamp_ns > stamp_ns) continue;
      const Entry& b = back(n - 1);
      const double t = rt::to_seconds(stamp_ns - a.stamp_ns) / rt::to_seconds(b.stamp_ns - a.stamp_ns);
      return {slerp(a.q_world_body, b.q_world_body, t), true};
    }
    const Entry& oldest = back(size_ - 1);
    return {oldest.q_world_body, oldest.stamp_ns - stamp_ns <= max_extrapolation_ns_};
  }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "attitude history")
        .fixed(spacing_ns_, max_extrapolation_ns_)
        .state(entries_)
        .by_hand(newest_, size_);
    archive.bounded(newest_, kEntries - 1);
    archive.bounded(size_, kEntries);
  }

 private:
  rt::Nanoseconds spacing_ns_;
  rt::Nanoseconds max_extrapolation_ns_;
  std::array<Entry, kEntries> entries_{};
  std::uint32_t newest_{kEntries - 1};
  std::uint32_t size_{};
};

}  // namespace sortie::estimators
