// SPDX-License-Identifier: BSD-3-Clause
// Drives that the map's sweep runs over: a recorded one, and one through a simulated hall whose faces are
// known.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {

/// Scans and, where the world is known, the face that each of their points lies on.
struct MapDrive {
  std::string name;
  std::vector<tests::RecordedScan> scans;
  std::vector<std::vector<std::uint32_t>> faces;  ///< as long as `scans`, or empty: nobody knows
  double half_height_m{5.5};                      ///< of the local map
};

/// Every `stride`-th point of a recorded drive; no scans where the file is not there.
MapDrive recorded_drive(const std::string& file, std::uint32_t stride);

/// Along the path of the furnished hall of `seed`: a scan of 24 x 480 rays every 0.3 m, ranges with 1 cm of
/// noise, poses true. A face is the plane side of a solid, or the whole of a round one.
MapDrive simulated_drive(std::uint64_t seed);

}  // namespace sortie::bench
