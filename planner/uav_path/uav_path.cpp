// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/uav_path.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

constexpr std::int32_t kStartReach = 3;  // voxels that a start may lie from the next free one
constexpr std::uint64_t kStartVoxels = (2 * kStartReach + 1) * (2 * kStartReach + 1) * (2 * kStartReach + 1);

std::uint64_t steps_of(std::uint64_t units) {
  return std::min(units, UINT64_MAX / UavPath::kStepsPerUnit) * UavPath::kStepsPerUnit;
}

}  // namespace

PathState UavPath::begin(const FlightMap& map, const rt::Vector3& start_m, const rt::Vector3& goal_m) {
  waypoint_count_ = 0;
  whole_ = shortest_ = walking_ = false;
  published_rounds_ = 0;
  tries_ = 0;
  start_m_ = start_m;
  goal_m_ = goal_m;
  map_version_ = map.version();
  if (!rt::is_finite(start_m)) return state_ = PathState::bad_start;
  goal_ = map.voxel_at(goal_m);
  if (!rt::is_finite(goal_m) || !map.is_free(goal_)) return state_ = PathState::bad_goal;
  start_ = map.voxel_at(start_m);
  phase_ = map.is_free(start_) ? Phase::coarse : Phase::lead_in;
  if (phase_ == Phase::coarse) coarse_.begin(map, start_, goal_);
  return state_ = PathState::running;
}

bool UavPath::walk_on(const FlightMap& map, std::uint64_t& steps) {
  const SweptCheck before = walk_.result();
  const bool ended = walk_.run(map, steps);
  work_.exact += walk_.result().queries - before.queries;
  work_.bricks += walk_.result().bricks - before.bricks;
  walking_ = !ended;
  return ended;
}

// From a start that is not free to the nearest free voxel that the robot can go to in a straight line.
void UavPath::lead_in(const FlightMap& map, std::uint64_t& steps) {
  while (steps > 0) {
    if (!walking_) {
      const double tried_m = tries_ == 0 ? -1.0 : rt::norm(map.middle_m(start_) - start_m_);
      if (tries_++ == kMostStarts || !map.nearest_free(start_m_, tried_m, kStartReach, start_)) {
        state_ = PathState::bad_start;
        return;
      }
      steps -= std::min(steps, kStartVoxels);
      walk_.begin(start_m_, map.middle_m(start_));
      walking_ = true;
      continue;
    }
    if (!walk_on(map, steps)) return;
    if (!walk_.result().is_free) continue;
    phase_ = Phase::coarse;
    coarse_.begin(map, start_, goal_);
    return;
  }
}

PathState UavPath::step(const FlightMap& map, std::uint64_t units) {
  if (state_ != PathState::running && state_ != PathState::found) return state_;
  if (map.version() != map_version_) {
    waypoint_count_ = 0;
    return state_ = PathState::outdated;
  }
  work_.units += units;
  if (phase_ == Phase::lead_in) {
    std::uint64_t steps = steps_of(units);
    lead_in(map, steps);
    units = steps / kStepsPerUnit;
  }
  if (phase_ == Phase::coarse || phase_ == Phase::fine) search(map, units);
  std::uint64_t steps = steps_of(units);
  while (steps > 0 && (state_ == PathState::running || state_ == PathState::found)) {
    if (phase_ == Phase::judge) {
      judge(map, steps);
    } else if (phase_ == Phase::shorten) {
      shortest_ = corners_.shorten(map, steps);
      if (corners_.rounds() != published_rounds_)
        begin_judging(map);
      else if (shortest_)
        state_ = PathState::done;
    } else {
      break;
    }
  }
  return state_;
}

void UavPath::search(const FlightMap& map, std::uint64_t& units) {
  if (phase_ == Phase::coarse && units > 0) {
    const SearchState search = coarse_.run(map, units);
    work_.parts = coarse_.size();
    if (search == SearchState::none) state_ = PathState::none;
    if (search == SearchState::capacity) state_ = PathState::capacity;
    if (search == SearchState::found) {
      phase_ = Phase::fine;
      fine_.begin(map, coarse_, start_, goal_);
    }
  }
  if (phase_ != Phase::fine || units == 0) return;
  const SearchState search = fine_.run(map, coarse_, units);
  if (search == SearchState::running) return;
  // Read off at once; counted all the same.
  Status taken = Status::ok;
  if (search == SearchState::found) {
    taken = corners_.take(fine_);
  } else {
    ++work_.crawled;
    taken = corners_.crawl(map, coarse_, start_, goal_);
  }
  units -= std::min<std::uint64_t>(units, corners_.points().size());
  if (taken == Status::ok)
    begin_judging(map);
  else
    state_ = PathState::capacity;
}

// The corners become the way, if the exact check agrees with what the voxels promise.
void UavPath::begin_judging(const FlightMap& map) {
  phase_ = Phase::judge;
  published_rounds_ = corners_.rounds();
  const std::span<const Voxel3> corners = corners_.points();
  fresh_count_ = 0;
  fresh_[fresh_count_++] = start_m_;
  std::uint32_t used = 0;
  while (used < corners.size() && fresh_count_ + 1 < kMostWaypoints)
    fresh_[fresh_count_++] = map.middle_m(corners[used++]);
  fresh_whole_ = used == corners.size();
  if (fresh_whole_) fresh_[fresh_count_++] = goal_m_;
  line_ = Line::without_first;
  point_ = 0;
  walking_ = false;
}

void UavPath::drop(std::uint32_t point) {
  std::copy(fresh_ + point + 1, fresh_ + fresh_count_, fresh_ + point);
  --fresh_count_;
}

// The middles of the first and the last voxel are bends that nobody needs, where the robot can pass without;
// then each line of what is left. False: no line is left.
bool UavPath::next_line() {
  if (line_ == Line::without_first) {
    if (fresh_count_ > 2) {
      walk_.begin(fresh_[0], fresh_[2]);
      return true;
    }
    line_ = Line::without_last;
  }
  if (line_ == Line::without_last) {
    if (fresh_whole_ && fresh_count_ > 2) {
      walk_.begin(fresh_[fresh_count_ - 3], fresh_[fresh_count_ - 1]);
      return true;
    }
    line_ = Line::each;
  }
  if (++point_ >= fresh_count_) return false;
  walk_.begin(fresh_[point_ - 1], fresh_[point_]);
  return true;
}

void UavPath::refuse() {
  ++work_.unsafe;
  phase_ = Phase::shorten;
  // What was shown before was checked, too.
  state_ = waypoint_count_ == 0 ? PathState::none : shortest_ ? PathState::done : PathState::found;
}

void UavPath::judge(const FlightMap& map, std::uint64_t& steps) {
  while (steps > 0) {
    if (!walking_ && !next_line()) {
      std::copy(fresh_, fresh_ + fresh_count_, waypoints_);
      waypoint_count_ = fresh_count_;
      whole_ = fresh_whole_;
      phase_ = Phase::shorten;
      state_ = shortest_ ? PathState::done : PathState::found;
      return;
    }
    walking_ = true;
    if (!walk_on(map, steps)) return;
    const bool is_free = walk_.result().is_free;
    if (line_ == Line::each) {
      if (!is_free) return refuse();
      continue;
    }
    if (is_free) drop(line_ == Line::without_first ? 1 : fresh_count_ - 2);
    line_ = line_ == Line::without_first ? Line::without_last : Line::each;
  }
}

double UavPath::length_m() const {
  double sum = 0.0;
  for (std::uint32_t i = 1; i < waypoint_count_; ++i) sum += rt::norm(waypoints_[i] - waypoints_[i - 1]);
  return sum;
}

}  // namespace sortie::planner
