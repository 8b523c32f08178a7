// SPDX-License-Identifier: BSD-3-Clause
// The newest poses of the body, so that a scan can be placed where the robot was when it was taken.
#pragma once

#include <cstdint>

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// A pose at one time.
struct StampedPose {
  rt::Nanoseconds stamp_ns{};
  rt::Vector3 p;
  rt::Quaternion q;
  SORTIE_FIELDS(stamp_ns, p, q)
};

/// Ring of the last kCapacity poses by stamp. About 16 kB, no heap. Deterministic.
class PoseHistory {
 public:
  static constexpr std::uint32_t kCapacity = 256;
  static constexpr rt::Nanoseconds kSlopeNs = 20 * rt::kNanosecondsPerMillisecond;

  /// Takes a pose. Status: ok; time_backwards or time_repeated (refused): stamps must rise.
  Status add(const StampedPose& pose) {
    if (count_ > 0 && pose.stamp_ns <= newest().stamp_ns) {
      return pose.stamp_ns == newest().stamp_ns ? Status::time_repeated : Status::time_backwards;
    }
    ring_[(first_ + count_) % kCapacity] = pose;
    if (count_ < kCapacity) {
      ++count_;
    } else {
      first_ = (first_ + 1) % kCapacity;
    }
    return Status::ok;
  }

  /// The pose at `stamp_ns`: between two neighbours positions linearly and orientation by slerp; up to
  /// `max_ahead_ns` behind the newest the newest moved on, at the mean motion of its last kSlopeNs: at
  /// 0.5 rad/s a pose that is held for 20 ms puts a wall at 10 m off by 10 cm. Status: ok; empty (no pose
  /// yet); stale (older than the oldest kept); out_of_range (too far ahead). Cost: one binary search and one
  /// slerp, 0.2 us.
  Status at(rt::Nanoseconds stamp_ns, rt::Nanoseconds max_ahead_ns, StampedPose& pose) const {
    if (count_ == 0) return Status::empty;
    if (stamp_ns >= newest().stamp_ns) {
      if (stamp_ns - newest().stamp_ns > max_ahead_ns) return Status::out_of_range;
      move_on(stamp_ns, pose);
      return Status::ok;
    }
    if (stamp_ns < entry(0).stamp_ns) return Status::stale;
    std::uint32_t low = 0;
    std::uint32_t high = count_ - 1;
    while (high - low > 1) {
      const std::uint32_t middle = (low + high) / 2;
      (entry(middle).stamp_ns <= stamp_ns ? low : high) = middle;
    }
    between(entry(low), entry(high), stamp_ns, pose);
    return Status::ok;
  }

  /// State to bytes and back: the poses that are kept, oldest first.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "pose history").by_hand(ring_, first_, count_);
    archive.bounded(count_, kCapacity);
    for (std::uint32_t i = 0; i < count_; ++i)
      archive.value(archive.is_reading() ? ring_[i] : ring_[(first_ + i) % kCapacity]);
    if (archive.is_reading()) first_ = 0;
  }

 private:
  static void between(const StampedPose& a, const StampedPose& b, rt::Nanoseconds stamp_ns,
                      StampedPose& pose) {
    const double share =
        static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
    pose.stamp_ns = stamp_ns;
    pose.p = a.p + share * (b.p - a.p);
    pose.q = rt::slerp(a.q, b.q, share);
  }

  // Along the newest pose and the youngest one that is kSlopeNs older (a single encoder count over 1 ms says
  // little of the speed); looks at 32 poses at most. A pose with no elder, or with a much older one alone,
  // stays where it is.
  void move_on(rt::Nanoseconds stamp_ns, StampedPose& pose) const {
    pose = newest();
    for (std::uint32_t back = 1; back < count_ && back <= 32; ++back) {
      const StampedPose& elder = entry(count_ - 1 - back);
      const rt::Nanoseconds span_ns = newest().stamp_ns - elder.stamp_ns;
      if (span_ns < kSlopeNs) continue;
      if (span_ns <= 10 * kSlopeNs) between(elder, newest(), stamp_ns, pose);
      return;
    }
  }

  const StampedPose& entry(std::uint32_t index) const { return ring_[(first_ + index) % kCapacity]; }
  const StampedPose& newest() const { return entry(count_ - 1); }

  StampedPose ring_[kCapacity]{};
  std::uint32_t first_{};
  std::uint32_t count_{};
};

}  // namespace sortie::mapping
