// SPDX-License-Identifier: BSD-3-Clause
// Chains: from a sample through tasks to an output. How long until a sample has its effect, and how old the
// sample behind an output is, follow from the table alone.
#pragma once

#include <cstdint>

#include "rt/schedule.hpp"

namespace sortie::rt {

/// Most groups that a chain passes, one after the other.
inline constexpr std::uint32_t kMaxChainLegs = 8;

/// A stay in one group. Values come in at one job and go out at the same, or `jobs_back` jobs later: once for
/// every backward read on the way, which sees the value of the job before.
struct ChainLeg {
  std::uint16_t group{};
  std::uint16_t port{};  ///< entered by: number of the stream (first leg) or of the input within the group
  std::uint32_t jobs_back{};
};

/// A task on the way.
struct ChainStep {
  std::uint16_t leg{};
  std::uint16_t task{};  ///< number within its group
  bool backward{};       ///< stands before the task of its group that it reads: sees the job before's value
};
inline constexpr std::uint32_t kMaxChainSteps = 24;

/// A path through the table.
struct Chain {
  FixedVector<ChainLeg, kMaxChainLegs> legs;
  FixedVector<ChainStep, kMaxChainSteps> steps;  ///< for those who follow values; bounds need legs only
  bool from_stream{};  ///< it begins with samples of a stream; otherwise with the first task's own release
  /// Longest time between two samples of the stream. 0: one arrives for every release.
  Nanoseconds source_interval_ns{};
};

/// What the table promises as long as no job misses its deadline and every job takes all samples that wait.
struct ChainBound {
  /// Longest time from the arrival of a sample to the deadline of the first output that knows of it. A sample
  /// that arrives just after a release waits for the next. Never reached, only approached.
  std::uint64_t reaction_ns{};
  /// Oldest that the newest sample behind an output can be when that output becomes visible. For samples that
  /// come less often than the first group is released, their interval is part of it.
  std::uint64_t age_ns{};
  bool exact{};  ///< false: the groups' pattern is too long to be walked; a bound from each hop's worst
};

/// Follows every job of the chain's first and last group through one hyperperiod of the groups on the way, or
/// bounds hop by hop when those are more than kMostReleases jobs. Set-up only. Needs a leg or more.
ChainBound chain_bound(const ScheduleTable& table, const Chain& chain);

}  // namespace sortie::rt
