// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/uav_path.hpp"

#include <algorithm>
#include <cmath>

#include "planner/uav_path/swept_check.hpp"

namespace sortie::planner {
namespace {

constexpr std::uint64_t kSightPerUnit = 16;
constexpr std::int32_t kStartReach = 3;  // voxels that a start may lie from the next free one

}  // namespace

PathState UavPath::begin(const FlightMap& map, const rt::Vector3& start_m, const rt::Vector3& goal_m) {
  waypoint_count_ = 0;
  whole_ = false;
  published_rounds_ = 0;
  phase_ = Phase::coarse;
  start_m_ = start_m;
  goal_m_ = goal_m;
  map_version_ = map.version();
  if (!rt::is_finite(start_m) || !find_free_start(map, start_m)) return state_ = PathState::bad_start;
  goal_ = map.voxel_at(goal_m);
  if (!rt::is_finite(goal_m) || !map.is_free(goal_)) return state_ = PathState::bad_goal;
  coarse_.begin(map, start_, goal_);
  return state_ = PathState::running;
}

// The start's own voxel, or the nearest free one that the robot can go to in a straight line.
bool UavPath::find_free_start(const FlightMap& map, const rt::Vector3& start_m) {
  start_ = map.voxel_at(start_m);
  if (map.is_free(start_)) return true;
  const Voxel3 middle = start_;
  double tried = -1.0;
  for (int tries = 0; tries < 64; ++tries) {
    double nearest = HUGE_VAL;  // but beyond those that were tried
    for (std::int32_t z = -kStartReach; z <= kStartReach; ++z) {
      for (std::int32_t y = -kStartReach; y <= kStartReach; ++y) {
        for (std::int32_t x = -kStartReach; x <= kStartReach; ++x) {
          const Voxel3 v{middle.x + x, middle.y + y, middle.z + z};
          const double d = rt::norm(map.middle_m(v) - start_m);
          if (d <= tried || d >= nearest || !map.is_free(v)) continue;
          nearest = d;
          start_ = v;
        }
      }
    }
    if (nearest == HUGE_VAL) return false;
    const SweptCheck check = check_swept(map, start_m, map.middle_m(start_));
    work_.exact += check.queries;
    if (check.is_free) return true;
    tried = nearest;
  }
  return false;
}

PathState UavPath::step(const FlightMap& map, std::uint64_t units) {
  if (state_ != PathState::running && state_ != PathState::found) return state_;
  if (map.version() != map_version_) {
    waypoint_count_ = 0;
    return state_ = PathState::outdated;
  }
  work_.units += units;
  if (phase_ == Phase::coarse && units > 0) {
    const SearchState search = coarse_.run(map, units);
    work_.parts = coarse_.size();
    if (search == SearchState::none) return state_ = PathState::none;
    if (search == SearchState::capacity) return state_ = PathState::capacity;
    if (search == SearchState::found) {
      phase_ = Phase::fine;
      fine_.begin(map, coarse_, start_, goal_);
    }
  }
  if (phase_ == Phase::fine && units > 0) {
    const SearchState search = fine_.run(map, coarse_, units);
    if (search == SearchState::found) {
      state_ = finish_search(map, corners_.take(map, fine_));
    } else if (search != SearchState::running) {
      ++work_.crawled;
      state_ = finish_search(map, corners_.crawl(map, coarse_, start_, goal_));
    }
  }
  if (phase_ != Phase::shorten || state_ != PathState::found || units == 0) return state_;
  std::uint64_t sight = std::min(units, UINT64_MAX / kSightPerUnit) * kSightPerUnit;
  const bool ended = corners_.shorten(map, sight);
  if (corners_.rounds() != published_rounds_) {
    published_rounds_ = corners_.rounds();
    if (!publish(map)) return state_ = PathState::none;
  }
  return state_ = ended ? PathState::done : PathState::found;
}

PathState UavPath::finish_search(const FlightMap& map, Status taken) {
  if (taken != Status::ok) return PathState::capacity;
  phase_ = Phase::shorten;
  return publish(map) ? PathState::found : PathState::none;
}

// The corners become the way, if the exact check agrees with what the voxels promise.
bool UavPath::publish(const FlightMap& map) {
  const std::span<const Voxel3> corners = corners_.points();
  rt::Vector3 fresh[kMostWaypoints];
  std::uint32_t count = 0;
  fresh[count++] = start_m_;
  std::uint32_t used = 0;
  while (used < corners.size() && count + 1 < kMostWaypoints) fresh[count++] = map.middle_m(corners[used++]);
  const bool whole = used == corners.size();
  if (whole) fresh[count++] = goal_m_;
  // The middles of the first and the last voxel are bends that nobody needs, where the robot can pass
  // without.
  const auto can_skip = [&](std::uint32_t i) {
    if (i == 0 || i + 1 >= count) return false;
    const SweptCheck check = check_swept(map, fresh[i - 1], fresh[i + 1]);
    work_.exact += check.queries;
    return check.is_free;
  };
  const auto drop = [&](std::uint32_t i) { std::copy(fresh + i + 1, fresh + count--, fresh + i); };
  if (can_skip(1)) drop(1);
  if (whole && count > 2 && can_skip(count - 2)) drop(count - 2);
  for (std::uint32_t i = 1; i < count; ++i) {
    const SweptCheck check = check_swept(map, fresh[i - 1], fresh[i]);
    work_.exact += check.queries;
    if (check.is_free) continue;
    ++work_.unsafe;
    return waypoint_count_ > 0;  // what was shown before was checked, too
  }
  std::copy(fresh, fresh + count, waypoints_);
  waypoint_count_ = count;
  whole_ = whole;
  return true;
}

double UavPath::length_m() const {
  double sum = 0.0;
  for (std::uint32_t i = 1; i < waypoint_count_; ++i) sum += rt::norm(waypoints_[i] - waypoints_[i - 1]);
  return sum;
}

bool UavPath::is_still_free(const FlightMap& map, std::span<const rt::Vector3> waypoints) {
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (!check_swept(map, waypoints[i - 1], waypoints[i]).is_free) return false;
  }
  return true;
}

}  // namespace sortie::planner
