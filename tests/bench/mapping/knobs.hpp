// SPDX-License-Identifier: BSD-3-Clause
// Error against run time of the local map: one knob after the other over a drive.
#pragma once

#include "tests/bench/mapping/drives.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Settings of one row.
struct MapCell {
  std::string knob;  ///< which one differs from the profile's, "profile" for none
  std::string value;
  double voxel_m{0.1};
  std::uint32_t min_points{1};
  std::uint32_t units{};   ///< of the segmenter a step; 0: all
  std::uint32_t solves{};  ///< normals a step; 0: all
};

/// How much to look at.
struct KnobOptions {
  std::size_t warm_up{40};  ///< scans before the first look
  std::size_t every{20};    ///< scans between two looks
};

/// Runs Euclidean and smoothness policies with every cell over the drive. Adds a table a policy, and the same
/// rows as objects under `map_rows`.
void sweep_knobs(const MapDrive& drive, const KnobOptions& options, Report& report);

}  // namespace sortie::bench
