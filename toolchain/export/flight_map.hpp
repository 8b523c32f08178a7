// SPDX-License-Identifier: BSD-3-Clause
// The map that one robot made, for another one to fly by.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/parts/uav_config.hpp"
#include "mapping/occupancy/occupancy_view.hpp"

namespace sortie::toolchain {

/// Gathers what an occupancy map says of a flight map's voxels while its window moves: a voxel that has left
/// the window stays what it was.
class FlightMapGatherer {
 public:
  /// `config`: of the flight map, its corner on a corner of a cell.
  explicit FlightMapGatherer(const firmware::GuideConfig& config);

  /// Takes over what the window shows by now. Throws InputError where its cells are not the map's voxels.
  void take(const mapping::OccupancyView& view);

  const std::vector<firmware::CellState>& cells() const { return cells_; }
  std::size_t count(firmware::CellState state) const;

 private:
  firmware::GuideConfig config_;
  std::vector<firmware::CellState> cells_;
};

/// Writes a scene that stands on `base` and flies by these cells. `comment`: lines about where they are from.
void write_flight_map(std::ostream& out, const std::string& base, const std::string& name,
                      const std::string& comment, const std::vector<firmware::CellState>& cells);

}  // namespace sortie::toolchain
