// SPDX-License-Identifier: BSD-3-Clause
// The guide's part for maps that are sensed: cells of the occupancy map in, and ways into the unknown.
#include <algorithm>
#include <cmath>

#include "planner/uav_guide.hpp"

namespace sortie::planner {

void UavGuide::expect(FlightMap& hope, const SensedCells& cells) {
  hope_ = &hope;
  cells_ = cells;
  while (!hope_->refresh(1000)) {
  }
}

void UavGuide::sense(const mapping::OccupancyView& view) {
  if (hope_ == nullptr || searching_ || checking_ != Checking::nothing) return;
  const FlightMapConfig& config = map_->config();
  const std::int32_t count[3] = {config.nx, config.ny, config.nz};
  std::int32_t first[3];
  std::int32_t end[3];
  for (int a = 0; a < 3; ++a) {  // the voxels that lie in the window
    first[a] = std::clamp(view.low[a] - cells_.low[a], 0, count[a]);
    end[a] = std::clamp(view.low[a] + view.size[a] - cells_.low[a], 0, count[a]);
  }
  std::uint64_t changed = 0;
  for (std::int32_t z = first[2]; z < end[2]; ++z) {
    for (std::int32_t y = first[1]; y < end[1]; ++y) {
      const std::int64_t row =
          std::int64_t{z + cells_.low[2] - view.low[2]} * view.size[1] + (y + cells_.low[1] - view.low[1]);
      const std::int8_t* cell = view.cells + row * view.size[0] + (cells_.low[0] - view.low[0]);
      for (std::int32_t x = first[0]; x < end[0]; ++x) {
        const int code = cell[x];
        if (code == mapping::kUnknownCell || (code > cells_.free_code && code <= cells_.blocked_code))
          continue;
        const Voxel3 voxel{x, y, z};
        const bool blocked = code > cells_.blocked_code;
        if (map_->is_blocked(voxel) == blocked && hope_->is_blocked(voxel) == blocked) continue;
        // Both lie inside of both maps.
        static_cast<void>(map_->set_blocked(voxel, blocked));
        static_cast<void>(hope_->set_blocked(voxel, blocked));
        ++changed;
      }
    }
  }
  counts_.voxels_changed += changed;
  refreshing_ = refreshing_ || changed != 0;
}

bool UavGuide::wants_hope() const {
  if (hope_ == nullptr || hoping_) return false;
  const auto state = static_cast<PathState>(way_.state);
  return state == PathState::none || state == PathState::bad_goal || state == PathState::bad_start;
}

void UavGuide::begin_hoped() {
  hoping_ = true;
  slices_ = 0;
  ++counts_.hoped;
  const PathState state =
      path_->begin(*hope_, rt::to_vector(question_.from_m), rt::to_vector(question_.to_m));
  way_.state = static_cast<std::uint32_t>(state);
  searching_ = state == PathState::running;
}

// Of a hoped way only the beginning that is known to be free: it ends in a free voxel, and the exact check
// has the last word. What is shorter than two voxels shows nothing new.
void UavGuide::cut() {
  note_path(cut_);
  const double voxel_m = map_->config().voxel_m;
  const auto point = [this](std::uint32_t i) { return rt::Vector3{cut_.x_m[i], cut_.y_m[i], cut_.z_m[i]}; };
  rt::Vector3 last = point(0);
  std::uint32_t points = 1;
  double gone_m = 0.0;
  double length_m = 0.0;
  bool free = true;
  for (std::uint32_t i = 1; free && i < cut_.points; ++i) {
    const rt::Vector3 a = point(i - 1);
    const rt::Vector3 way = point(i) - a;
    const double leg_m = rt::norm(way);
    const double steps = std::ceil(4.0 * leg_m / voxel_m);
    for (double s = 1.0; free && s <= steps; s += 1.0) {
      const rt::Vector3 p = a + (s / steps) * way;
      const double here_m = gone_m + s / steps * leg_m;
      free = map_->is_free(map_->voxel_at(p));
      if (free) {
        last = p;
        length_m = here_m;
        points = i + 1;
      } else {
        free = length_m == 0.0 && here_m <= 3.0 * voxel_m;  // from a start beside free voxels
      }
    }
    gone_m += leg_m;
  }
  const auto put = [this](std::uint32_t i, const rt::Vector3& p) {
    cut_.x_m[i] = p.x;
    cut_.y_m[i] = p.y;
    cut_.z_m[i] = p.z;
  };
  put(points - 1, last);
  for (std::uint32_t i = points; i < UavWay::kMostPoints; ++i) put(i, {});
  cut_.points = points;
  cut_.whole = 0;
  cut_.length_m = length_m;
  if (length_m < 2.0 * voxel_m) return end_cut(false);
  way_.state = static_cast<std::uint32_t>(PathState::running);
  checking_ = Checking::hoped;
  walk_.begin();
}

void UavGuide::end_cut(bool is_free) {
  const UavWay none;
  const UavWay& way = is_free ? cut_ : none;
  way_.state = static_cast<std::uint32_t>(is_free ? PathState::done : PathState::none);
  way_.points = way.points;
  way_.whole = 0;
  way_.length_m = way.length_m;
  std::copy(way.x_m, way.x_m + UavWay::kMostPoints, way_.x_m);
  std::copy(way.y_m, way.y_m + UavWay::kMostPoints, way_.y_m);
  std::copy(way.z_m, way.z_m + UavWay::kMostPoints, way_.z_m);
  counts_.begun += is_free ? 1 : 0;
  cut_ = {};
}

}  // namespace sortie::planner
