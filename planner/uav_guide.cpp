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
  slices_ = 0;
  checking_ = Checking::nothing;
  hoping_ = false;
  begun_version_ = version();
  way_.points = way_.whole = way_.blocked = 0;
  way_.number = question_.number;
  way_.state = static_cast<std::uint32_t>(
      path_->begin(*map_, rt::to_vector(question_.from_m), rt::to_vector(question_.to_m)));
  searching_ = static_cast<PathState>(way_.state) == PathState::running;
  if (!searching_ && wants_hope()) begin_hoped();
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
  if (searching_) return;
  if (checking_ != Checking::nothing) {  // a check under way begins anew
    walk_.begin();
    if (checking_ == Checking::hoped) checked_version_ = map_->version();
  }
  if (checking_ == Checking::hoped || way_.points == 0 || checked_version_ == map_->version()) return;
  checked_version_ = map_->version();
  if (way_.blocked != 0) return;
  checking_ = Checking::shown;
  walk_.begin();
}

// A slice of an exact check.
void UavGuide::check() {
  const UavWay& way = checking_ == Checking::hoped ? cut_ : way_;
  rt::Vector3 points[UavWay::kMostPoints];
  for (std::uint32_t i = 0; i < way.points; ++i) points[i] = {way.x_m[i], way.y_m[i], way.z_m[i]};
  std::uint64_t steps = kSlice * UavPath::kStepsPerUnit;
  if (!walk_.run(*map_, {points, way.points}, steps)) return;
  const Checking what = checking_;
  checking_ = Checking::nothing;
  if (what == Checking::hoped) {
    end_cut(walk_.is_free());
  } else if (!walk_.is_free()) {
    way_.blocked = 1;
    ++counts_.blocked;
  }
}

void UavGuide::note_path(UavWay& way) const {
  way.state = static_cast<std::uint32_t>(path_->state());
  const auto points = path_->waypoints();
  way.points = std::min(static_cast<std::uint32_t>(points.size()), UavWay::kMostPoints);
  for (std::uint32_t i = 0; i < UavWay::kMostPoints; ++i) {
    const rt::Vector3 p = i < way.points ? points[i] : rt::Vector3{};
    way.x_m[i] = p.x;
    way.y_m[i] = p.y;
    way.z_m[i] = p.z;
  }
  way.whole = path_->is_whole() ? 1 : 0;
  way.length_m = way.points != 0 ? path_->length_m() : 0.0;
}

void UavGuide::step() {
  if (refreshing_) {
    const bool known = map_->refresh(kBricksPerSlice);
    if (known && (hope_ == nullptr || hope_->refresh(kBricksPerSlice))) refreshed();
    return;
  }
  if (checking_ != Checking::nothing) return check();
  if (!searching_) return;
  ++slices_;
  const PathState state = path_->step(hoping_ ? *hope_ : *map_, kSlice);
  if (state == PathState::running || state == PathState::found) return;
  way_.state = static_cast<std::uint32_t>(state);
  if (wants_hope()) {
    begin_hoped();
    return;
  }
  searching_ = false;
  checked_version_ = map_->version();
  if (hoping_ && state == PathState::done)
    cut();
  else
    note_path(way_);
}

void UavGuide::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "uav guide")
      .fixed(map_, path_, boxes_, hope_, cells_)
      .by_hand(known_, checking_)
      .state(started_, refreshing_, searching_, start_ns_, begun_version_, slices_, checked_version_,
             question_, way_, walk_, cut_, hoping_, counts_);
  auto checking = static_cast<std::uint32_t>(checking_);
  archive.bounded(checking, static_cast<std::uint32_t>(Checking::hoped));
  checking_ = static_cast<Checking>(checking);
  archive.bounded(known_, boxes_.size());
  archive.value(*map_);
  if (hope_ != nullptr) archive.value(*hope_);
  if (archive.is_reading() && hoping_ && hope_ == nullptr) archive.fail(Status::malformed, "a hoped way");
  if (!archive.is_reading() || archive.status() != Status::ok) return;
  if (std::max(way_.points, cut_.points) > UavWay::kMostPoints)
    archive.fail(Status::malformed, "a way of too many points");
  if (!searching_) return;
  // A search in a map that has changed since begins anew anyway, once the change is worked in.
  const FlightMap& map = hoping_ ? *hope_ : *map_;
  PathState state = path_->begin(map, rt::to_vector(question_.from_m), rt::to_vector(question_.to_m));
  for (std::uint32_t i = 0; i < slices_ && (state == PathState::running || state == PathState::found); ++i)
    state = path_->step(map, kSlice);
}

}  // namespace sortie::planner
