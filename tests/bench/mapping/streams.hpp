// SPDX-License-Identifier: BSD-3-Clause
// What the map is fed with in the sweep: recorded scans, and a simulated hall.
#pragma once

#include <string>
#include <vector>

#include "mapping/grid/rolling_grid_config.hpp"
#include "rt/samples.hpp"

namespace sortie::bench {

/// A scan and where it was taken (world from sensor).
struct MappingScan {
  std::vector<rt::ScanPoint> points;
  mapping::RigidPose pose;

  rt::PointScan view() const;
};

/// Scans in their order.
struct MappingStream {
  std::string name;
  std::string about;
  std::vector<MappingScan> scans;
};

/// Every `stride`-th point of a recording (.rls); no scans when the file is not there.
MappingStream recorded_stream(const std::string& name, const std::string& file, std::uint32_t stride);

/// A hall of 26 x 18 x 4.5 m with pillars and boxes, cast with 16 x 512 rays from a sensor that drives a
/// curve; 1.5 cm of noise along the ray. The same scans each time.
MappingStream simulated_hall();

}  // namespace sortie::bench
