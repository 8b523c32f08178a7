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
  if (hope_ == nullptr || searching_ || checking_) return;
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

// After each search of a sensed map: true when the answer is there, or another search was begun.
bool UavGuide::goes_on(PathState state) {
  const bool no_way =
      state == PathState::none || state == PathState::bad_goal || state == PathState::bad_start;
  if (search_ == Search::known) {
    if (!no_way) return false;
    if (state == PathState::bad_start) {
      begin_backing();
    } else {
      ++counts_.hoped;
      begin(Search::hoped);
    }
    return true;
  }
  if (search_ == Search::hoped &&
      state == PathState::bad_start) {  // the goal was bad as well, and told first
    begin_backing();
    return true;
  }
  if (search_ == Search::hoped) {
    if (no_way) ++counts_.hopeless;
    if (state != PathState::done) return false;
    take_aims();
  } else if (state == PathState::done) {
    ++counts_.begun;
    return false;
  } else {
    ++aims_.next;
  }
  if (aims_.next < aims_.count && state != PathState::bad_start) {  // from there no aim can be reached
    begin(Search::aimed);
    return true;
  }
  way_.state = static_cast<std::uint32_t>(PathState::none);
  return true;
}

// Out of a place that is too near to something, in a straight line, keeping the room that there is: the first
// lines go nowhere and tell that room.
void UavGuide::begin_backing() {
  search_ = Search::backing;
  way_.state = static_cast<std::uint32_t>(PathState::running);
  searching_ = true;
  aims_ = WayAims{};
  std::copy(std::begin(question_.from_m), std::end(question_.from_m), std::begin(aims_.p_world_m[0]));
  share_ = 0.9;
  walk_.begin(share_);
}

// A slice of it.
void UavGuide::back_off() {
  const rt::Vector3 points[2] = {rt::to_vector(question_.from_m), rt::to_vector(aims_.p_world_m[0])};
  std::uint64_t steps = kSlice * UavPath::kStepsPerUnit;
  if (!walk_.run(*map_, points, steps)) return;
  const bool measures = aims_.next == 0;
  if (walk_.is_free() && !measures) {
    for (std::uint32_t p = 0; p < 2; ++p) way_.set_point(p, points[p]);
    way_.points = 2;
    way_.length_m = rt::norm(points[1] - points[0]);
    way_.state = static_cast<std::uint32_t>(PathState::done);
    searching_ = false;
    checked_version_ = map_->version();
    ++counts_.backed_off;
  } else if (measures && !walk_.is_free() && share_ > 0.55) {
    share_ -= 0.1;
    walk_.begin(share_);
  } else if (walk_.is_free() || !measures) {
    try_next_place();
  } else {
    give_up_backing();
  }
}

// The nearest free voxel beyond those that were tried.
void UavGuide::try_next_place() {
  constexpr std::int32_t kReach = 4;
  const rt::Vector3 start = rt::to_vector(question_.from_m);
  const double tried = aims_.next == 0 ? -1.0 : rt::norm(rt::to_vector(aims_.p_world_m[0]) - start);
  Voxel3 voxel;
  if (aims_.next == UavPath::kMostStarts || !map_->nearest_free(start, tried, kReach, voxel))
    return give_up_backing();
  ++aims_.next;
  rt::store(map_->middle_m(voxel), aims_.p_world_m[0]);
  walk_.begin(share_);
}

void UavGuide::give_up_backing() {
  share_ = 1.0;
  searching_ = false;
  checked_version_ = map_->version();
  way_.state = static_cast<std::uint32_t>(PathState::bad_start);
}

// Back along the hoped way from the goal: where a stretch of it that is known to be free ends. What is nearer
// than two voxels shows nothing new. With more of them than room the last place is the one nearest the start.
void UavGuide::take_aims() {
  aims_ = WayAims{};
  const double voxel_m = map_->config().voxel_m;
  const std::span<const rt::Vector3> points = path_->waypoints();
  // Who stands in the goal's stretch cannot be met there: the goal could not. A way of too many corners ends
  // before the goal.
  bool free = path_->is_whole();
  for (std::size_t i = points.size() - 1; i > 0; --i) {
    const rt::Vector3 way = points[i - 1] - points[i];
    const double steps = std::ceil(4.0 * rt::norm(way) / voxel_m);
    for (double s = 0.0; s < steps; s += 1.0) {
      const rt::Vector3 p = points[i] + (s / steps) * way;
      const bool was_free = free;
      free = map_->is_free(map_->voxel_at(p));
      if (was_free || !free || rt::norm(p - points[0]) < 2.0 * voxel_m) continue;
      rt::store(p, aims_.p_world_m[std::min(aims_.count, WayAims::kMost - 1)]);
      aims_.count = std::min(aims_.count + 1, WayAims::kMost);
    }
  }
}

bool UavGuide::is_consistent() const {
  if (search_ == Search::known) return true;
  return hope_ != nullptr && search_ <= Search::backing && aims_.count <= WayAims::kMost &&
         (search_ != Search::aimed || !searching_ || aims_.next < aims_.count);
}

}  // namespace sortie::planner
