// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/export/flight_map.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

FlightMapGatherer::FlightMapGatherer(const firmware::GuideConfig& config) : config_(config) {
  const planner::FlightMapConfig& map = config_.map;
  cells_.resize(std::size_t(map.nx) * std::size_t(map.ny) * std::size_t(map.nz),
                firmware::CellState::unknown);
}

void FlightMapGatherer::take(const mapping::OccupancyView& view) {
  const planner::FlightMapConfig& map = config_.map;
  if (std::fabs(view.voxel_size_m - map.voxel_m) > 1e-9) {
    throw firmware::InputError(
        "the log's map has cells of " + firmware::format_short(view.voxel_size_m) +
            " m, the flight map voxels of " + firmware::format_short(map.voxel_m) +
            " m; record with --set occupancy.voxel_m=" + firmware::format_short(map.voxel_m),
        2);
  }
  const std::int32_t count[3] = {map.nx, map.ny, map.nz};
  std::int32_t first[3];
  std::int32_t end[3];
  for (int a = 0; a < 3; ++a) {  // the voxels that lie in the window
    first[a] = std::clamp(view.low[a] - config_.cells.low[a], 0, count[a]);
    end[a] = std::clamp(view.low[a] + view.size[a] - config_.cells.low[a], 0, count[a]);
  }
  for (std::int32_t z = first[2]; z < end[2]; ++z) {
    for (std::int32_t y = first[1]; y < end[1]; ++y) {
      for (std::int32_t x = first[0]; x < end[0]; ++x) {
        const std::int32_t at[3] = {x + config_.cells.low[0] - view.low[0],
                                    y + config_.cells.low[1] - view.low[1],
                                    z + config_.cells.low[2] - view.low[2]};
        const int code = view.cells[(std::int64_t{at[2]} * view.size[1] + at[1]) * view.size[0] + at[0]];
        if (code == mapping::kUnknownCell) continue;
        firmware::CellState& cell =
            cells_[(std::size_t(z) * std::size_t(map.ny) + std::size_t(y)) * std::size_t(map.nx) +
                   std::size_t(x)];
        if (code > config_.cells.blocked_code) cell = firmware::CellState::blocked;
        if (code <= config_.cells.free_code) cell = firmware::CellState::free;
      }
    }
  }
}

std::size_t FlightMapGatherer::count(firmware::CellState state) const {
  return static_cast<std::size_t>(std::count(cells_.begin(), cells_.end(), state));
}

void write_flight_map(std::ostream& out, const std::string& base, const std::string& name,
                      const std::string& comment, const std::vector<firmware::CellState>& cells) {
  out << "# " << comment << "\n[scene]\nname = \"" << name << "\"\nbase = \"" << base
      << "\"\n\n[flight_map]\nsource = \"stored\"\ncells = \"" << firmware::pack_cells(cells) << "\"\n";
}

}  // namespace sortie::toolchain
