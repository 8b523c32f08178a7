// SPDX-License-Identifier: BSD-3-Clause
// The pairing of an estimated trajectory with its truth by time, and reading one from a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "firmware_like/timed_pose.hpp"

namespace sortie::firmware {

/// The pose at `stamp_ns` between two neighbours: positions linearly, orientation along the shorter arc
/// (slerp). A flag is set if both neighbours have it. Returns false outside the span or where the neighbours
/// are more than `max_gap_ns` apart. Cost: one binary search.
bool interpolate(std::span<const TimedPose> trajectory, std::int64_t stamp_ns, std::int64_t max_gap_ns,
                 TimedPose& pose);

/// An estimate and its truth at the same stamps, element by element. The truth's flags say what can be
/// judged: what either of the two lacks is not set.
struct PairedTrajectories {
  Trajectory estimate;
  Trajectory truth;
  std::size_t skipped{};  ///< stamps without a partner: outside the other's span, or in one of its gaps
};

/// How samples are paired.
struct AssociationOptions {
  double max_gap_s{0.0};  ///< no interpolation across longer gaps; 0: five median steps, at least 50 ms
};

/// Pairs by time: the denser of the two is interpolated at the stamps of the sparser (equal: at the truth's).
/// Samples of the truth without kTruthPosition still pair (their orientation may count). Both inputs must be
/// tidy.
PairedTrajectories associate(std::span<const TimedPose> estimate, std::span<const TimedPose> truth,
                             const AssociationOptions& options = {});

/// Reads a TUM trajectory: `t tx ty tz qx qy qz qw` a line, '#' starts a comment. Stamps are kept to the
/// nanosecond. Throws InputError (exit code 3) naming file and line.
Trajectory read_tum(const std::string& path);

}  // namespace sortie::firmware
