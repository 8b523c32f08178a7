// SPDX-License-Identifier: BSD-3-Clause
// Decides whether the stamp of a sample can be believed. One wild stamp must not lock a filter out for ever,
// and a sensor whose clock really was set anew must be taken back after a few consistent samples.
#pragma once

#include <cstdint>

#include "rt/archive.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// True for a stamp so wild that a difference of two could overflow: 73 years to either side are none.
constexpr bool is_far(Nanoseconds stamp) {
  constexpr Nanoseconds kFar = Nanoseconds{1} << 61;
  return stamp > kFar || stamp < -kFar;
}

/// Gate for the stamps of one stream. 40 bytes, a few comparisons a sample, safe for any 64-bit stamps. The
/// stamps that it takes lie within +-146 years of the epoch, so that their differences never overflow.
class StampGate {
 public:
  /// A step forward of more than `max_step_ns` is doubted, and so is every step back. `confirmations` doubted
  /// stamps in a row that rise by no more than `max_step_ns` each are believed: the stream goes on there.
  constexpr explicit StampGate(Nanoseconds max_step_ns, std::uint32_t confirmations = 8)
      : max_step_ns_(max_step_ns), confirmations_(confirmations) {}

  /// Judges the stamp of a sample that is otherwise good. `ok` takes it as the stream's newest;
  /// `time_repeated`, `time_backwards` and `out_of_range` (too far ahead) leave the newest stamp as it was.
  constexpr Status take(Nanoseconds stamp) {
    resumed_ = false;
    if (stamp > kFarthest || stamp < -kFarthest) return Status::out_of_range;
    if (!started_) {
      started_ = true;
      return accept(stamp);
    }
    if (stamp == last_) return Status::time_repeated;
    const bool ahead = stamp > last_;
    if (ahead && stamp - last_ <= max_step_ns_) return accept(stamp);
    const bool follows = doubted_ > 0 && stamp > doubt_ && stamp - doubt_ <= max_step_ns_;
    doubted_ = follows ? doubted_ + 1 : 1;
    doubt_ = stamp;
    if (doubted_ >= confirmations_) {
      resumed_ = true;
      return accept(stamp);
    }
    return ahead ? Status::out_of_range : Status::time_backwards;
  }

  /// Newest stamp taken. Meaningless before the first.
  constexpr Nanoseconds last() const { return last_; }
  /// True when a stamp has been taken.
  constexpr bool started() const { return started_; }
  /// True when the newest stamp began a new time line: its distance to the one before says nothing.
  constexpr bool resumed() const { return resumed_; }

  /// State to bytes and back.
  void archive(Archive& archive) {
    Members(archive, *this, "stamp gate")
        .state(last_, doubt_, doubted_, started_, resumed_)
        .fixed(max_step_ns_, confirmations_);
  }

 private:
  static constexpr Nanoseconds kFarthest = Nanoseconds{1} << 62;

  constexpr Status accept(Nanoseconds stamp) {
    last_ = stamp;
    doubted_ = 0;
    return Status::ok;
  }

  Nanoseconds max_step_ns_;
  Nanoseconds last_{};
  Nanoseconds doubt_{};
  std::uint32_t confirmations_;
  std::uint32_t doubted_{};
  bool started_{};
  bool resumed_{};
};

}  // namespace sortie::rt
