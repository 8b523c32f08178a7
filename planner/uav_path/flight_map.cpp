// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/flight_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rt/convex/query.hpp"

namespace sortie::planner {
namespace {

bool is_edge(std::int32_t n) { return n >= 4 && n <= 1024 && n % kBrickEdge == 0; }

bool is_length(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

std::uint32_t FlightMap::bricks_for(const FlightMapConfig& config) {
  if (!is_edge(config.nx) || !is_edge(config.ny) || !is_edge(config.nz)) return 0;
  return static_cast<std::uint32_t>(config.nx / 4) * static_cast<std::uint32_t>(config.ny / 4) *
         static_cast<std::uint32_t>(config.nz / 4);
}

FlightMap::FlightMap(const FlightMapConfig& config, std::span<BrickMask> blocked, std::span<BrickMask> free,
                     std::span<std::uint64_t> dirty)
    : config_(config), blocked_(blocked), free_(free), dirty_(dirty) {
  const std::uint32_t bricks = bricks_for(config);
  const double reach =
      std::ceil(std::max({config.radii_m.x, config.radii_m.y, config.radii_m.z}) / config.voxel_m + 1.5);
  if (bricks == 0 || blocked.size() != bricks || free.size() != bricks ||
      dirty.size() != dirty_words_for(config) || !is_length(config.voxel_m) ||
      !rt::is_finite(config.origin_m) || !is_length(config.radii_m.x) ||
      config.radii_m.x != config.radii_m.y || !is_length(config.radii_m.z) || !(reach <= kMostReach)) {
    usable_ = Status::out_of_range;
    config_.nx = config_.ny = config_.nz = 0;
    return;
  }
  bx_ = config.nx / 4;
  by_ = config.ny / 4;
  reach_ = static_cast<std::int32_t>(reach);
  make_offsets();
  std::fill(blocked_.begin(), blocked_.end(), config.unknown_is_blocked ? kWholeBrick : BrickMask{0});
  std::fill(free_.begin(), free_.end(), BrickMask{0});
  for (std::uint32_t b = 0; b < bricks; ++b) dirty_[b / 64] |= std::uint64_t{1} << (b % 64);
}

// Which blocked voxels, seen from a voxel's middle, are too near. "Too near" unless a gap of half a voxel's
// diagonal was proved: query() never claims more of a gap than there is.
void FlightMap::make_offsets() {
  const double half = 0.5 * config_.voxel_m;
  const double gap = 1.7320508075688773 * half;
  const rt::convex::Convex robot = rt::convex::make_swept_ellipsoid(config_.radii_m, {});
  rt::convex::Convex voxel = rt::convex::make_box({half, half, half});
  for (std::int32_t z = -reach_; z <= reach_; ++z) {
    for (std::int32_t y = -reach_; y <= reach_; ++y) {
      for (std::int32_t x = -reach_; x <= reach_; ++x) {
        voxel.p_world_m = config_.voxel_m *
                          rt::Vector3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        const rt::convex::QueryResult q = rt::convex::query(robot, voxel);
        if (q.state == rt::convex::State::separated && -q.depth_m >= gap) continue;
        if (offset_count_ == kMostOffsets) {
          usable_ = Status::out_of_range;
          return;
        }
        offsets_[offset_count_++] = {static_cast<std::int8_t>(x), static_cast<std::int8_t>(y),
                                     static_cast<std::int8_t>(z)};
      }
    }
  }
}

Status FlightMap::set_blocked(const Voxel3& voxel, bool blocked) {
  if (!is_inside(voxel)) return Status::out_of_range;
  BrickMask& word = blocked_[brick_of(voxel)];
  const BrickMask bit = brick_bit(voxel);
  if (((word & bit) != 0) == blocked) return Status::ok;
  word ^= bit;
  // The bricks of all voxels that see this one.
  for (std::int32_t z = std::max(voxel.z - reach_, 0) / 4;
       z <= std::min(voxel.z + reach_, config_.nz - 1) / 4; ++z) {
    for (std::int32_t y = std::max(voxel.y - reach_, 0) / 4;
         y <= std::min(voxel.y + reach_, config_.ny - 1) / 4; ++y) {
      for (std::int32_t x = std::max(voxel.x - reach_, 0) / 4;
           x <= std::min(voxel.x + reach_, config_.nx - 1) / 4; ++x) {
        const auto b = static_cast<std::uint32_t>(x + bx_ * (y + by_ * z));
        dirty_[b / 64] |= std::uint64_t{1} << (b % 64);
      }
    }
  }
  return Status::ok;
}

bool FlightMap::refresh(std::uint32_t most_bricks) {
  const auto words = static_cast<std::uint32_t>(dirty_.size());
  std::uint32_t done = 0;
  std::uint32_t clean = 0;
  while (clean < words && done < most_bricks) {
    std::uint64_t& word = dirty_[hand_];
    if (word == 0) {
      ++clean;
      hand_ = hand_ + 1 < words ? hand_ + 1 : 0;
      continue;
    }
    clean = 0;
    const std::uint32_t b = hand_ * 64 + static_cast<std::uint32_t>(std::countr_zero(word));
    word &= word - 1;
    free_[b] = free_voxels(b);
    ++done;
  }
  if (done != 0) ++version_;  // also where no free voxel changed: exact checks ask the blocked ones
  return clean == words;
}

bool FlightMap::nearest_free(const rt::Vector3& from_m, double beyond_m, std::int32_t reach,
                             Voxel3& found) const {
  const Voxel3 middle = voxel_at(from_m);
  double nearest = HUGE_VAL;
  for (std::int32_t z = middle.z - reach; z <= middle.z + reach; ++z) {
    for (std::int32_t y = middle.y - reach; y <= middle.y + reach; ++y) {
      for (std::int32_t x = middle.x - reach; x <= middle.x + reach; ++x) {
        const double d = rt::norm(middle_m({x, y, z}) - from_m);
        if (d <= beyond_m || d >= nearest || !is_free({x, y, z})) continue;
        nearest = d;
        found = {x, y, z};
      }
    }
  }
  return nearest < HUGE_VAL;
}

// One brick anew.
BrickMask FlightMap::free_voxels(std::uint32_t brick) const {
  const BrickMask own = blocked_[brick];
  if (own == kWholeBrick) return 0;
  const Voxel3 corner = corner_of(brick);
  // Nothing blocked in any brick within reach, and the map's border is far: all of it is free.
  const std::int32_t span = (reach_ + 3) / 4 * 4;
  BrickMask near = 0;
  bool border = false;
  for (std::int32_t z = corner.z - span; z <= corner.z + span; z += 4) {
    for (std::int32_t y = corner.y - span; y <= corner.y + span; y += 4) {
      for (std::int32_t x = corner.x - span; x <= corner.x + span; x += 4) {
        if (is_inside({x, y, z}))
          near |= blocked_[brick_of({x, y, z})];
        else
          border = true;
      }
    }
  }
  if (near == 0 && !border) return kWholeBrick;
  BrickMask free = 0;
  for (int bit = 0; bit < 64; ++bit) {
    const Voxel3 v = brick_voxel(corner, bit);
    bool open = (own & brick_bit(v)) == 0;
    for (std::uint32_t o = 0; open && o < offset_count_; ++o)
      open = !is_blocked({v.x + offsets_[o].x, v.y + offsets_[o].y, v.z + offsets_[o].z});
    if (open) free |= brick_bit(v);
  }
  return free;
}

rt::Vector3 FlightMap::middle_m(const Voxel3& v) const {
  const double h = config_.voxel_m;
  return {config_.origin_m.x + h * (v.x + 0.5), config_.origin_m.y + h * (v.y + 0.5),
          config_.origin_m.z + h * (v.z + 0.5)};
}

Voxel3 FlightMap::voxel_at(const rt::Vector3& p) const {
  const auto number = [this](double value, double origin) {
    const double n = std::floor((value - origin) / config_.voxel_m);
    return n >= -1.0 && n <= 1024.0 ? static_cast<std::int32_t>(n) : -1;  // a NaN lies outside
  };
  return {number(p.x, config_.origin_m.x), number(p.y, config_.origin_m.y), number(p.z, config_.origin_m.z)};
}

void FlightMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "flight map")
      .fixed(config_, usable_, bx_, by_, reach_, offset_count_, offsets_)
      .state(version_)
      .by_hand(blocked_, free_, dirty_, hand_);
  archive.expect(blocked_.size(), "the map has another size");
  for (const std::span<std::uint64_t> words : {blocked_, free_, dirty_}) {
    for (std::uint64_t& word : words) archive.value(word);
  }
  archive.bounded(hand_, dirty_.empty() ? 0 : dirty_.size() - 1);
  // Bits behind the last brick would point out of the map.
  if (const std::size_t rest = blocked_.size() % 64; archive.is_reading() && rest != 0)
    dirty_.back() &= (std::uint64_t{1} << rest) - 1;
}

}  // namespace sortie::planner
