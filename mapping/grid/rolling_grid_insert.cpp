// SPDX-License-Identifier: BSD-3-Clause
// Points into the rolling grid. First every point finds its block, then each block that was hit takes all its
// points at once: sums of whole numbers, so that their order does not matter.
#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/grid/rolling_grid.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kBatch = 16;
constexpr std::uint32_t kNoEntry = 0xffffffffu;
constexpr std::int32_t kBiasBlocks = 1024;  ///< makes coordinates relative to the sensor's block positive
constexpr double kLimitCells = 4.0 * (BlockAt::kLimit - 2048);
}  // namespace

/// What the points of one scan sum up to in one block.
struct RollingGrid::Seen {
  struct Sum {
    std::uint64_t x;
    std::uint64_t y;
    std::uint64_t z;
    std::uint64_t count;
  };
  std::array<Sum, Block::kCells> cells;
};

RollingInsert RollingGrid::refuse(const rt::PointScan& scan, Status why) {
  RollingInsert result{why, {}};
  result.points.in = scan.header.points;
  (why == Status::not_supported ? result.points.out_of_grid : result.points.bad_pose) = scan.header.points;
  rt::add_fields(result.points, output_.points);
  ++output_.scans;
  changed_ = 0;
  return result;
}

RollingInsert RollingGrid::insert(const rt::PointScan& scan, const RigidPose& pose, rt::Tick tick,
                                  const EvictionHook& hook) {
  if (!rt::is_finite(pose.p) || !rt::is_finite(pose.q)) return refuse(scan, Status::not_finite);
  if (!usable_ || std::fabs(squared_norm(pose.q) - 1.0) > 1e-3) return refuse(scan, Status::out_of_range);
  if (scan.points == nullptr && scan.header.points > 0) return refuse(scan, Status::malformed);
  const RigidPose grid_sensor{rt::rotate_back(world_grid_.q, pose.p - world_grid_.p),
                              normalised(conjugate(world_grid_.q) * normalised(pose.q))};
  const double to_cells = 1.0 / config_.voxel_size_m;
  const rt::Vector3 at = to_cells * grid_sensor.p;
  if (!(std::fabs(at.x) < kLimitCells && std::fabs(at.y) < kLimitCells && std::fabs(at.z) < kLimitCells))
    return refuse(scan, Status::not_supported);
  centre_ = {static_cast<std::int32_t>(std::floor(0.25 * at.x)),
             static_cast<std::int32_t>(std::floor(0.25 * at.y)),
             static_cast<std::int32_t>(std::floor(0.25 * at.z))};

  RollingInsert result;
  RollingGridCounts& counts = result.points;
  const auto tick32 = static_cast<std::uint32_t>(tick);
  counts.in = scan.header.points;
  evict_beyond(tick32, hook, counts);
  changed_ = 0;
  locate(scan, grid_sensor, counts, hook);
  Seen seen;
  for (Seen::Sum& sum : seen.cells) sum = {};
  for (std::uint32_t i = 0; i < changed_; ++i) {
    if (i + 2 < changed_) __builtin_prefetch(&memory_.blocks[memory_.changes[i + 2].block]);
    if (i + 1 < changed_) prefetch_voxels(memory_.blocks[memory_.changes[i + 1].block]);
    merge(memory_.changes[i], seen, tick32, hook, counts);
  }
  for (std::uint32_t i = 0; i < changed_; ++i) {
    const BlockIndex index = memory_.changes[i].block;
    memory_.blocks[index].touch = Block::kUntouched;
    if (memory_.blocks[index].occupied == 0) evict(index, {}, counts);  // nothing found room in it
  }
  rt::add_fields(counts, output_.points);
  ++output_.scans;
  if (counts.pool_full + counts.scan_full > 0) result.status = Status::full;
  return result;
}

/// Finds every point's block and hangs the point on its list. Entries of the window and blocks are fetched
/// ahead, a batch at a time.
void RollingGrid::locate(const rt::PointScan& scan, const RigidPose& grid_sensor, RollingGridCounts& counts,
                         const EvictionHook& hook) {
  struct Located {
    BlockAt at;
    std::uint32_t entry;
    ScanEntry point;
  };
  const double to_cells = 1.0 / config_.voxel_size_m;
  const rt::RotationMatrix turn = to_matrix(grid_sensor.q);
  // Relative to the sensor's block, in cells.
  const rt::Vector3 shift =
      to_cells * grid_sensor.p - 4.0 * rt::Vector3{1.0 * centre_.x, 1.0 * centre_.y, 1.0 * centre_.z};
  const double near2 = config_.min_range_m * config_.min_range_m;
  const double far2 = config_.max_range_m * config_.max_range_m;
  const double radius2 = config_.radius_m * config_.radius_m * to_cells * to_cells;
  const double height = config_.half_height_m * to_cells;
  const auto room = static_cast<std::uint32_t>(memory_.scan.size());
  std::uint32_t taken = 0;
  std::array<Located, kBatch> batch;
  for (std::uint32_t begin = 0; begin < scan.header.points; begin += kBatch) {
    const std::uint32_t end = std::min(scan.header.points, begin + kBatch);
    std::uint32_t located = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
      const rt::ScanPoint& point = scan.points[i];
      const rt::Vector3 p{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                          static_cast<double>(point.z_m)};
      const double range2 = dot(p, p);
      if (!std::isfinite(range2)) {  // floats squared in double cannot overflow
        ++counts.not_finite;
        continue;
      }
      if (range2 < near2 || range2 > far2) {
        ++(range2 < near2 ? counts.too_near : counts.too_far);
        continue;
      }
      const rt::Vector3 d = to_cells * (turn * p);
      if (!(d.x * d.x + d.y * d.y <= radius2 && std::fabs(d.z) <= height)) {
        ++counts.outside;
        continue;
      }
      if (taken + located == room) {
        ++counts.scan_full;
        continue;
      }
      Located& found = batch[located++];
      const rt::Vector3 u = d + shift;  // less than 1010 cells: fits in 27 bits with 16 bits behind the point
      const auto fixed = [](double cells) {
        return static_cast<std::uint32_t>(static_cast<std::int32_t>((cells + 4.0 * kBiasBlocks) * 65536.0));
      };
      const std::uint32_t x = fixed(u.x);
      const std::uint32_t y = fixed(u.y);
      const std::uint32_t z = fixed(u.z);
      const auto block_of = [](std::uint32_t v) { return static_cast<std::int32_t>(v >> 18) - kBiasBlocks; };
      found.at = {centre_.x + block_of(x), centre_.y + block_of(y), centre_.z + block_of(z)};
      found.point = {
          kNoEntry,
          {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), static_cast<std::uint16_t>(z)},
          static_cast<std::uint16_t>((x >> 16 & 3) | (y >> 14 & 12) | (z >> 12 & 48))};
      found.entry = window_.entry(found.at);
      window_.prefetch(found.entry);
    }
    for (std::uint32_t i = 0; i < located; ++i) {
      const BlockIndex index = window_[batch[i].entry];
      if (index != kNoBlock) __builtin_prefetch(&memory_.blocks[index]);
    }
    for (std::uint32_t i = 0; i < located; ++i) {
      const Located& found = batch[i];
      BlockIndex index = window_[found.entry];
      if (index == kNoBlock || memory_.blocks[index].key != found.at.key()) {
        index = take_block(found.at, hook, counts);
        if (index == kNoBlock) {
          ++counts.pool_full;
          continue;
        }
      }
      Block& block = memory_.blocks[index];
      if (block.touch == Block::kUntouched) {
        block.touch = static_cast<std::uint16_t>(changed_);
        memory_.changes[changed_++] = {0, 0, kNoEntry, index, 0};
      }
      BlockChange& change = memory_.changes[block.touch];
      memory_.scan[taken] = found.point;
      memory_.scan[taken].next = change.first;
      change.first = taken++;
    }
  }
}

/// Moves a block's voxels apart so that the fresh cells lie in order among them.
void RollingGrid::make_room(Block& block, std::uint64_t fresh) {
  const std::uint64_t all = block.occupied | fresh;
  unsigned from = bits_in(block.occupied);
  unsigned to = bits_in(all);
  for (std::uint64_t left = all; from < to;) {
    const unsigned cell = 63u - static_cast<unsigned>(std::countl_zero(left));
    left &= ~cell_bit(cell);
    const std::uint32_t target = block.slot(--to);
    if ((fresh & cell_bit(cell)) != 0) {
      memory_.voxels[target] = Centroid{};
      if (!holds_normals()) continue;
      memory_.normals[target] = SurfaceNormal{};
      memory_.sums[target] = NormalSums{};
    } else {
      const std::uint32_t source = block.slot(--from);
      memory_.voxels[target] = memory_.voxels[source];
      if (!holds_normals()) continue;
      memory_.normals[target] = memory_.normals[source];
      memory_.sums[target] = memory_.sums[source];
    }
  }
  block.occupied = all;
}

void RollingGrid::merge(BlockChange& change, Seen& seen, std::uint32_t tick, const EvictionHook& hook,
                        RollingGridCounts& counts) {
  Block& block = memory_.blocks[change.block];
  block.last_tick = tick;
  std::uint64_t hit = 0;
  for (std::uint32_t i = change.first; i != kNoEntry; i = memory_.scan[i].next) {
    const ScanEntry& point = memory_.scan[i];
    Seen::Sum& sum = seen.cells[point.cell];
    hit |= cell_bit(point.cell);
    sum.x += point.offset[0];
    sum.y += point.offset[1];
    sum.z += point.offset[2];
    ++sum.count;
  }
  std::uint64_t fresh = hit & ~block.occupied;
  while (fresh != 0 && !take_chunks(block, bits_in(block.occupied | fresh))) {
    if (force_out(BlockAt::from_key(block.key), hook, counts)) continue;
    const unsigned last = 63u - static_cast<unsigned>(std::countl_zero(fresh));
    counts.pool_full += seen.cells[last].count;
    seen.cells[last] = {};
    fresh &= ~cell_bit(last);
    hit &= ~cell_bit(last);
  }
  if (fresh != 0) {
    make_room(block, fresh);
    const unsigned created = bits_in(fresh);
    counts.created += created;
    output_.voxels += created;
    output_.most_voxels = std::max(output_.most_voxels, output_.voxels);
  }
  std::uint64_t first = 0;  // squared, of the two voxels that move farthest
  std::uint64_t second = 0;
  for (; hit != 0; hit = without_lowest(hit)) {
    const unsigned cell = lowest(hit);
    Seen::Sum& sum = seen.cells[cell];
    Centroid& c = memory_.voxels[block.slot(block.rank(cell))];
    const std::uint64_t known = std::min<std::uint64_t>(c.count, config_.mean_window);
    const double share = 1.0 / static_cast<double>(known + sum.count);
    const auto mean = [known, share](std::uint16_t old, std::uint64_t fresh_sum) {
      const double value = static_cast<double>(known * old + fresh_sum) * share + 0.5;
      return static_cast<std::uint16_t>(std::min(value, 65535.0));
    };
    const Centroid next{mean(c.x, sum.x), mean(c.y, sum.y), mean(c.z, sum.z),
                        static_cast<std::uint16_t>(std::min<std::uint64_t>(c.count + sum.count, 65535))};
    counts.used += sum.count;
    sum = {};
    const bool active = next.count >= config_.min_points;
    if (active && (c.count < config_.min_points)) change.activated |= cell_bit(cell);
    if (active && (c.x != next.x || c.y != next.y || c.z != next.z)) {
      change.moved |= cell_bit(cell);
      const auto square = [](std::uint16_t a, std::uint16_t b) {
        const std::int64_t d = a - b;
        return static_cast<std::uint64_t>(d * d);
      };
      if ((block.active & cell_bit(cell)) != 0) {
        const std::uint64_t d = square(c.x, next.x) + square(c.y, next.y) + square(c.z, next.z);
        second = std::max(second, std::min(first, d));
        first = std::max(first, d);
      }
    }
    c = next;
  }
  const double apart = std::sqrt(static_cast<double>(first)) + std::sqrt(static_cast<double>(second));
  change.drift = static_cast<std::uint16_t>(static_cast<std::uint32_t>(apart) / kDriftStep + 1);
  block.active |= change.activated;
  change.moved |= change.activated;
}

}  // namespace sortie::mapping
