// SPDX-License-Identifier: BSD-3-Clause
// Walks the ticks at which some group of a declared table is released, in order: what every exact figure
// about a table is computed from.
#pragma once

#include <cstdint>

#include "rt/schedule.hpp"

namespace sortie::rt {

/// Visits releases from tick 0 through the last phase and two hyperperiods: by then a table that does not ask
/// for more than it gets has begun to repeat itself. Cost: a few ns for each group and release.
class ReleaseWalk {
 public:
  ReleaseWalk(const ScheduleTable& table, GroupSet set) : table_(table) {
    std::uint64_t last_phase = 0;
    for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
      if (((set >> i) & 1u) == 0) continue;
      const GroupTiming& timing = table.groups[i].timing;
      members_[count_] = i;
      next_[count_++] = timing.phase;
      last_phase = timing.phase > last_phase ? timing.phase : last_phase;
    }
    repeats_after_ = hyperperiod(table, set);
    // Beyond 2^62 ticks nobody walks that far anyway.
    end_ = repeats_after_ == 0 || repeats_after_ > kFar ? 2 * kFar : last_phase + 2 * repeats_after_;
    find_next();
  }

  /// Releases of the whole walk. Counts no further than a little above `most`.
  std::uint64_t releases(std::uint64_t most) const {
    std::uint64_t sum = 0;
    for (std::uint32_t i = 0; i < count_ && sum <= most; ++i)
      sum += end_ / table_.groups[members_[i]].timing.period + 1;
    return sum;
  }

  /// Goes on to the next tick with a release. False at the end of the walk.
  bool next() {
    if (upcoming_ >= end_ || count_ == 0) return false;
    tick_ = upcoming_;
    released_ = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (next_[i] != tick_) continue;
      released_ |= GroupSet{1} << members_[i];
      next_[i] += table_.groups[members_[i]].timing.period;
    }
    find_next();
    return true;
  }

  /// The tick that is visited, who is released there, and how far it is to the next release.
  std::uint64_t tick() const { return tick_; }
  GroupSet released() const { return released_; }
  std::uint64_t ticks_to_next() const { return upcoming_ - tick_; }
  /// True in the last hyperperiod of the walk, which has the same releases whatever the phases.
  bool in_last_hyperperiod() const { return end_ - tick_ <= repeats_after_; }

 private:
  static constexpr std::uint64_t kFar = std::uint64_t{1} << 61;

  void find_next() {
    upcoming_ = ~std::uint64_t{0};
    for (std::uint32_t i = 0; i < count_; ++i) upcoming_ = next_[i] < upcoming_ ? next_[i] : upcoming_;
  }

  const ScheduleTable& table_;
  std::uint32_t members_[kMaxGroups]{};
  std::uint64_t next_[kMaxGroups]{};
  std::uint32_t count_{};
  std::uint64_t repeats_after_{};
  std::uint64_t end_{};
  std::uint64_t tick_{};
  GroupSet released_{};
  std::uint64_t upcoming_{};
};

}  // namespace sortie::rt
