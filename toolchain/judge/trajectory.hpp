// SPDX-License-Identifier: BSD-3-Clause
// The pairing of an estimated trajectory with its truth by time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware_like/log/timed_pose.hpp"

namespace sortie::toolchain {

/// The pose at `stamp_ns` between two neighbours: positions linearly, orientation along the shorter arc
/// (slerp). A flag is set if both neighbours have it. Returns false outside the span or where the neighbours
/// are more than `max_gap_ns` apart. Cost: one binary search.
bool interpolate(std::span<const firmware::TimedPose> trajectory, std::int64_t stamp_ns,
                 std::int64_t max_gap_ns, firmware::TimedPose& pose);

/// An estimate and its truth at the same stamps, element by element. The truth's flags say what can be
/// judged: what either of the two lacks is not set.
struct PairedTrajectories {
  firmware::Trajectory estimate;
  firmware::Trajectory truth;
  std::size_t skipped{};  ///< stamps without a partner: outside the other's span, or in one of its gaps
};

/// Pairs by time: the denser of the two is interpolated at the stamps of the sparser (equal: at the truth's),
/// but not across gaps longer than five median steps, at least 50 ms. Samples of the truth without
/// kTruthPosition still pair (their orientation may count). Both inputs must be tidy.
PairedTrajectories associate(std::span<const firmware::TimedPose> estimate,
                             std::span<const firmware::TimedPose> truth);

}  // namespace sortie::toolchain
