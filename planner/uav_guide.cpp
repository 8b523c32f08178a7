// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_guide.hpp"

#include <algorithm>

namespace sortie::planner {

UavGuide::UavGuide(FlightMap& map, UavPath& path, std::span<const KnownBox> boxes)
    : map_(&map), path_(&path), boxes_(boxes) {
  while (known_ < boxes_.size() && boxes_[known_].from_ns <= 0) put_box(boxes_[known_++]);
  while (!map_->refresh(1000)) {
  }
  checked_version_ = way_.map_version = map_->version();
  way_.boxes = known_;
}

// Every voxel that the box touches. The planner keeps half a voxel's diagonal beyond the vehicle's own size.
void UavGuide::put_box(const KnownBox& box) {
  const FlightMapConfig& config = map_->config();
  const Voxel3 low = map_->voxel_at(box.lowest_m + rt::Vector3{1e-9, 1e-9, 1e-9});
  const Voxel3 high = map_->voxel_at(box.highest_m - rt::Vector3{1e-9, 1e-9, 1e-9});
  // Beyond the map voxel_at() gives -1 on either side: the box is cut off at the border it crosses.
  const auto last = [](std::int32_t at, double value, double origin, std::int32_t n) {
    return at < 0 && value > origin ? n - 1 : std::min(at, n - 1);
  };
  const std::int32_t x1 = last(high.x, box.highest_m.x, config.origin_m.x, config.nx);
  const std::int32_t y1 = last(high.y, box.highest_m.y, config.origin_m.y, config.ny);
  const std::int32_t z1 = last(high.z, box.highest_m.z, config.origin_m.z, config.nz);
  const auto first = [](std::int32_t at, double value, double origin, std::int32_t n) {
    return at < 0 ? (value > origin ? n : 0) : at;
  };
  const std::int32_t x0 = first(low.x, box.lowest_m.x, config.origin_m.x, config.nx);
  const std::int32_t y0 = first(low.y, box.lowest_m.y, config.origin_m.y, config.ny);
  const std::int32_t z0 = first(low.z, box.lowest_m.z, config.origin_m.z, config.nz);
  for (std::int32_t z = z0; z <= z1; ++z) {
    for (std::int32_t y = y0; y <= y1; ++y) {
      for (std::int32_t x = x0; x <= x1; ++x) static_cast<void>(map_->set_blocked({x, y, z}, true));
    }
  }
}

void UavGuide::begin() {
  checking_ = false;
  begun_version_ = version();
  way_.points = way_.whole = way_.blocked = 0;
  way_.number = question_.number;
  share_ = 1.0;
  begin(Search::known);
}

void UavGuide::begin(Search search) {
  search_ = search;
  slices_ = 0;
  const PathState state = begin_path();
  way_.state = static_cast<std::uint32_t>(state);
  searching_ = state == PathState::running;
  if (!searching_) ended();
}

PathState UavGuide::begin_path() {
  const auto& to = search_ == Search::aimed ? aims_.p_world_m[aims_.next] : question_.to_m;
  return path_->begin(searched(), rt::to_vector(question_.from_m), rt::to_vector(to));
}

void UavGuide::look(const WayQuestion* question, rt::Nanoseconds now_ns) {
  if (!started_) {
    started_ = true;
    start_ns_ = now_ns;
  }
  while (known_ < boxes_.size() && boxes_[known_].from_ns <= now_ns - start_ns_) {
    put_box(boxes_[known_++]);
    refreshing_ = true;
  }
  way_.boxes = known_;
  if (question == nullptr || question->number == question_.number) return;
  question_ = *question;
  begin();
}

// The map has become another: a search begins anew, a way is looked at again.
void UavGuide::refreshed() {
  refreshing_ = false;
  way_.map_version = map_->version();
  if (searching_ && begun_version_ != version()) begin();
  if (searching_ || way_.points == 0 || checked_version_ == map_->version()) return;
  checked_version_ = map_->version();
  checking_ = way_.blocked == 0;
  walk_.begin(share_);  // one under way begins anew
}

// A slice of the exact check of the way that is shown.
void UavGuide::check() {
  rt::Vector3 points[UavWay::kMostPoints];
  for (std::uint32_t i = 0; i < way_.points; ++i) points[i] = {way_.x_m[i], way_.y_m[i], way_.z_m[i]};
  std::uint64_t steps = kSlice * UavPath::kStepsPerUnit;
  if (!walk_.run(*map_, {points, way_.points}, steps)) return;
  checking_ = false;
  if (walk_.is_free()) return;
  way_.blocked = 1;
  ++counts_.blocked;
}

void UavGuide::note_path() {
  way_.state = static_cast<std::uint32_t>(path_->state());
  const auto points = path_->waypoints();
  way_.points = std::min(static_cast<std::uint32_t>(points.size()), UavWay::kMostPoints);
  for (std::uint32_t i = 0; i < UavWay::kMostPoints; ++i)
    way_.set_point(i, i < way_.points ? points[i] : rt::Vector3{});
  way_.whole = path_->is_whole() && search_ == Search::known ? 1 : 0;
  way_.length_m = way_.points != 0 ? path_->length_m() : 0.0;
}

void UavGuide::step() {
  if (refreshing_) {
    const bool known = map_->refresh(kBricksPerSlice);
    if (known && (hope_ == nullptr || hope_->refresh(kBricksPerSlice))) refreshed();
    return;
  }
  if (checking_) return check();
  if (!searching_) return;
  if (search_ == Search::backing) return back_off();
  ++slices_;
  const PathState state = path_->step(searched(), kSlice);
  if (state == PathState::running || state == PathState::found) return;
  way_.state = static_cast<std::uint32_t>(state);
  ended();
}

// A search is over.
void UavGuide::ended() {
  searching_ = false;
  checked_version_ = map_->version();
  if (hope_ != nullptr && goes_on(static_cast<PathState>(way_.state))) return;
  note_path();
}

void UavGuide::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav guide")
      .fixed(map_, path_, boxes_, hope_, cells_)
      .by_hand(known_)
      .state(started_, refreshing_, searching_, start_ns_, begun_version_, slices_, checked_version_,
             checking_, question_, way_, walk_, search_, aims_, share_, counts_);
  archive.bounded(known_, boxes_.size());
  archive.value(*map_);
  if (hope_ != nullptr) archive.value(*hope_);
  if (archive.is_reading() && !is_consistent()) archive.fail(Status::malformed, "a hoped way");
  if (!archive.is_reading() || archive.status() != Status::ok) return;
  if (way_.points > UavWay::kMostPoints || (checking_ && way_.points == 0))
    archive.fail(Status::malformed, "a way of too many points, or none");
  if (!searching_ || search_ == Search::backing) return;
  // A search in a map that has changed since begins anew anyway, once the change is worked in.
  PathState state = begin_path();
  for (std::uint32_t i = 0; i < slices_ && (state == PathState::running || state == PathState::found); ++i)
    state = path_->step(searched(), kSlice);
}

}  // namespace sortie::planner
