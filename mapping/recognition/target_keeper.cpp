// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/target_keeper.hpp"

#include <algorithm>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kMost_m = 40'000.0;
}

PlaceCm to_cm(const rt::Vector3& place_m) {
  const auto whole = [](double m) {
    const double near = m > -kMost_m ? std::min(m, kMost_m) : -kMost_m;  // of what is no number, too
    return static_cast<std::int32_t>(rt::floor(100.0 * near + 0.5));
  };
  return {whole(place_m.x), whole(place_m.y), whole(place_m.z)};
}

rt::Vector3 middle_of(const RollingGrid& grid) {
  const double edge_m = 4.0 * grid.config().voxel_size_m;
  const BlockAt& at = grid.centre();
  return grid.to_world({edge_m * at.x, edge_m * at.y, edge_m * at.z});
}

TargetKeeper::TargetKeeper(const TargetKeeperConfig& config, const TargetStoreConfig& store, rt::Arena& arena)
    : config_(config), store_(store, arena) {}

/// A new one where the middle of the local map is far from that of the last one. False: there is none at all.
bool TargetKeeper::find_key_frame(const RollingGrid& grid, const RigidPose& T_map_world) {
  KeyFramePose pose;
  pose.place = to_cm(T_map_world.p + rt::rotate(T_map_world.q, middle_of(grid)));
  const rt::Vector3 ahead = rt::rotate(T_map_world.q, {1, 0, 0});
  const bool has_one = key_frames_ > 0;
  if (!heading_of(ahead.x, ahead.y, pose.heading)) return has_one;
  const double least_cm = 100.0 * config_.key_frame_m;
  if (has_one && static_cast<double>(square_apart(newest().place, pose.place)) < least_cm * least_cm)
    return true;
  if (key_frames_ == store_.config().key_frames) return has_one;
  if (store_.set_key_frame(static_cast<std::uint16_t>(key_frames_), pose) != Status::ok) return has_one;
  ++key_frames_;
  return true;
}

void TargetKeeper::keep(std::span<const WatchedSegment> segments, const RollingGrid& grid,
                        const RigidPose& T_map_world, rt::Nanoseconds now_ns) {
  if (!find_key_frame(grid, T_map_world)) return;
  for (const WatchedSegment& segment : segments) {
    if (!segment.speaks || segment.version_at_ns != now_ns) continue;
    const PlaceCm& of_grid = segment.place;
    const rt::Vector3 in_world = grid.to_world({0.01 * of_grid.x, 0.01 * of_grid.y, 0.01 * of_grid.z});
    TargetSighting sighting;
    sighting.id = segment.id;
    sighting.stamp_ms = static_cast<std::uint32_t>(now_ns / 1'000'000);
    sighting.voxels = segment.described.voxels;
    sighting.key_frame = static_cast<std::uint16_t>(key_frames_ - 1);
    sighting.version = static_cast<std::uint16_t>(segment.version);
    sighting.robot = static_cast<std::uint8_t>(config_.robot);
    sighting.offset = offset_of(newest(), to_cm(T_map_world.p + rt::rotate(T_map_world.q, in_world)));
    sighting.descriptor = segment.descriptor;
    static_cast<void>(store_.put(sighting));
  }
}

void TargetKeeper::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "target keeper").fixed(config_).state(store_, key_frames_);
  if (!archive.is_reading() || key_frames_ == 0) return;
  if (key_frames_ > store_.key_frames().key_frames() ||
      !store_.key_frames().knows(static_cast<std::uint16_t>(key_frames_ - 1))) {
    archive.fail(Status::malformed, "a key frame that is not there");
    key_frames_ = 0;
  }
}

}  // namespace sortie::mapping
