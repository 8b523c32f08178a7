// SPDX-License-Identifier: BSD-3-Clause
// A map and a plan to bytes and back, for keyframes. Every index that is read is held within its table.
#include "planner/uav_path/uav_path.hpp"

#include <cmath>

namespace sortie::planner {
namespace {

// An index below `end`, or a mark that stands for none: `mark` or above.
void index(rt::Archive& archive, std::uint32_t& value, std::uint64_t end, std::uint32_t mark) {
  archive.value(value);
  if (!archive.is_reading() || value < end || value >= mark) return;
  archive.fail(Status::malformed, "an index points out of its table");
  value = UINT32_MAX;
}

template <class T>
void all_of(rt::Archive& archive, std::span<T> values) {
  for (T& value : values) archive.value(value);
}

// A voxel near enough to a map that differences of two cannot overflow.
void place(rt::Archive& archive, Voxel3& v) {
  archive.value(v);
  const auto is_far = [](std::int32_t n) { return n < -8192 || n > 8192; };
  if (!is_far(v.x) && !is_far(v.y) && !is_far(v.z)) return;
  archive.fail(Status::malformed, "a voxel lies far out of any map");
  v = {};
}

template <class State>
void state_of(rt::Archive& archive, State& state, State last) {
  auto number = static_cast<std::uint32_t>(state);
  archive.bounded(number, static_cast<std::uint32_t>(last));
  state = static_cast<State>(number);
}

}  // namespace

void FlightMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "flight map")
      .fixed(config_, usable_, bx_, by_, reach_, offset_count_, offsets_)
      .state(version_)
      .by_hand(blocked_, free_, dirty_, hand_);
  archive.expect(blocked_.size(), "the map has another size");
  all_of(archive, blocked_);
  all_of(archive, free_);
  all_of(archive, dirty_);
  archive.bounded(hand_, dirty_.empty() ? 0 : dirty_.size() - 1);
  // Bits behind the last brick would point out of the map.
  if (const std::size_t rest = blocked_.size() % 64; archive.is_reading() && rest != 0)
    dirty_.back() &= (std::uint64_t{1} << rest) - 1;
}

void CoarseSearch::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "coarse search")
      .by_hand(nodes_, brick_nodes_, heap_, count_, start_, state_)
      .state(start_point_);
  archive.expect(brick_nodes_.size(), "the map of the search has another size");
  archive.bounded(count_, nodes_.size());
  index(archive, start_, count_, kNoNode);
  state_of(archive, state_, SearchState::capacity);
  for (std::uint32_t i = 0; i < count_; ++i) {
    PathNode& node = nodes_[i];
    archive.value(node.voxels);
    archive.value(node.middle);
    archive.value(node.to_goal);
    archive.value(node.estimate);
    archive.bounded(node.brick, brick_nodes_.empty() ? 0 : brick_nodes_.size() - 1);
    index(archive, node.sibling, i, kNoNode);  // older ones alone: no rings
    index(archive, node.next, count_, kNoNode);
    index(archive, node.place, count_, kSettled);
  }
  for (std::uint32_t& first : brick_nodes_) index(archive, first, count_, kUnseen);
  heap_.archive(archive, count_);
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (nodes_[i].place >= kSettled || heap_.holds(i, nodes_[i].place)) continue;
    archive.fail(Status::malformed, "a part is not where it says in the heap");
    nodes_[i].place = kSettled;
  }
}

void FineSearch::archive(rt::Archive& archive, std::uint32_t nodes) {
  rt::Members(archive, *this, "fine search")
      .by_hand(table_, target_points_, target_lengths_, heap_, count_, goal_slot_, goal_, state_);
  place(archive, goal_);
  archive.expect(table_.size(), "the table of the search has another size");
  archive.bounded(count_, table_.size() - table_.size() / 4);  // without gaps nothing would be found in it
  index(archive, goal_slot_, table_.size(), kNoNode);
  state_of(archive, state_, SearchState::capacity);
  std::uint32_t found = 0;
  for (FineVoxel& voxel : table_) {
    archive.value(voxel.key);
    if (voxel.key == 0) continue;
    ++found;
    archive.value(voxel.from_start);
    archive.value(voxel.estimate);
    archive.bounded(voxel.parent, table_.size() - 1);
    index(archive, voxel.place, table_.size(), kSettled);
  }
  if (archive.is_reading() && found != count_) {
    archive.fail(Status::malformed, "the table of the search holds another number of voxels");
    state_ = SearchState::none;
  }
  for (std::uint32_t i = 0; i < nodes && i < target_lengths_.size() && i < target_points_.size(); ++i) {
    archive.value(target_points_[i]);
    archive.value(target_lengths_[i]);
  }
  heap_.archive(archive, static_cast<std::uint32_t>(table_.size()));
  for (std::uint32_t slot = 0; slot < table_.size(); ++slot) {
    FineVoxel& voxel = table_[slot];
    if (voxel.key == 0 || voxel.place >= kSettled || heap_.holds(slot, voxel.place)) continue;
    archive.fail(Status::malformed, "a voxel is not where it says in the heap");
    voxel.place = kSettled;
  }
}

void Corners::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "corners")
      .by_hand(memory_, count_, source_)
      .state(rounds_, last_length_, sampled_);
  archive.expect(memory_.points.size(), "the way has another room");
  archive.bounded(count_, memory_.points.size());
  archive.bounded(source_, count_);
  for (std::uint32_t i = 0; i < count_; ++i) {
    place(archive, memory_.points[i]);
    // Between rounds, and where no line has led yet, the place before is not used: left over from another
    // way.
    if (source_ == 0) memory_.lengths[i] = 0.0f;
    archive.value(memory_.lengths[i]);
    if (source_ == 0 || !(memory_.lengths[i] < HUGE_VALF)) memory_.before[i] = 0;
    archive.bounded(memory_.before[i], i == 0 ? 0 : i - 1);
  }
}

void UavPath::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav path")
      .by_hand(fine_, state_, phase_, start_, goal_, waypoint_count_, fresh_count_, line_, point_)
      .state(coarse_, corners_, map_version_, published_rounds_, start_m_, goal_m_, waypoints_, whole_,
             shortest_, tries_, fresh_, fresh_whole_, walking_, walk_, work_);
  place(archive, start_);
  place(archive, goal_);
  fine_.archive(archive, coarse_.size());
  state_of(archive, state_, PathState::outdated);
  state_of(archive, phase_, Phase::shorten);
  state_of(archive, line_, Line::each);
  archive.bounded(waypoint_count_, kMostWaypoints);
  archive.bounded(fresh_count_, kMostWaypoints);
  archive.bounded(point_, kMostWaypoints);
  if (archive.is_reading() && phase_ == Phase::judge && fresh_count_ < (line_ == Line::each ? 2u : 3u) &&
      walking_) {
    archive.fail(Status::malformed, "a line is judged that the way does not have");
    state_ = PathState::none;
  }
}

}  // namespace sortie::planner
