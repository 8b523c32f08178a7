// SPDX-License-Identifier: BSD-3-Clause
// Insertion into the voxel grid. Points go through in blocks: first where they belong, with the table's lines
// fetched ahead, then into their voxels.
#include "mapping/voxel_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kBlock = 16;
constexpr std::uint32_t kEvictionWindow = 16;
constexpr double kCellLimit = static_cast<double>(Cell::kLimit - 1);

/// Step of an offset within the cell, from a fraction in [0, 1].
std::uint32_t offset_step(double fraction) {
  const auto step = static_cast<std::uint32_t>(fraction * Voxel::kOffsetSteps);
  return std::min(step, Voxel::kOffsetSteps - 1);
}

bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }

double squared_distance(const rt::Vector3& a, const rt::Vector3& b) { return dot(a - b, a - b); }

rt::Vector3 centre_of(std::uint64_t key, double size_m) {
  const Cell cell = Cell::from_key(key);
  return size_m * rt::Vector3{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5};
}
}  // namespace

/// A point that belongs to a cell.
struct VoxelGrid::Located {
  std::uint64_t key;
  std::uint32_t offset[3];
  VoxelTable::Place place;
  rt::Vector3 p_world_m;
};

VoxelGrid::VoxelGrid(const VoxelGridConfig& config, const VoxelGridMemory& memory)
    : config_(config),
      inverse_size_(1.0 / config.voxel_size_m),
      usable_(is_positive(config.voxel_size_m) && is_positive(inverse_size_) &&
              is_positive(config.max_range_m) && config.min_range_m >= 0.0 && !memory.pool.empty() &&
              memory.pool.size() < Voxel::kUntouched && memory.buckets.size() >= 2),
      pool_(memory.pool),
      table_(memory.buckets) {}

Status VoxelGrid::set_ranges(double min_m, double max_m) {
  if (!(min_m >= 0.0 && is_positive(max_m) && min_m < max_m)) return Status::out_of_range;
  config_.min_range_m = min_m;
  config_.max_range_m = max_m;
  return Status::ok;
}

InsertResult VoxelGrid::insert(const rt::PointScan& scan, rt::Tick tick) {
  if ((scan.header.flags & rt::kScanPosed) == 0) return refuse_scan(scan, Status::not_supported);
  return insert(scan,
                {rt::to_vector(scan.header.p_world_sensor_m), rt::to_quaternion(scan.header.q_world_sensor)},
                tick);
}

InsertResult VoxelGrid::insert(const rt::PointScan& scan, const SensorPose& pose, rt::Tick tick) {
  if (!is_finite(pose.p_world_sensor_m) || !is_finite(pose.q_world_sensor))
    return refuse_scan(scan, Status::not_finite);
  const bool rotation = std::fabs(squared_norm(pose.q_world_sensor) - 1.0) < 1e-3;
  if (!usable_ || !rotation) return refuse_scan(scan, Status::out_of_range);
  if (scan.points == nullptr && scan.header.points > 0) return refuse_scan(scan, Status::malformed);

  const rt::RotationMatrix r = to_matrix(normalised(pose.q_world_sensor));
  const double near2 = config_.min_range_m * config_.min_range_m;
  const double far2 = config_.max_range_m * config_.max_range_m;
  const auto tick32 = static_cast<std::uint32_t>(tick);
  sensor_m_ = pose.p_world_sensor_m;
  InsertResult result;
  VoxelGridCounts& counts = result.points;
  counts.in = scan.header.points;
  std::array<Located, kBlock> block;
  for (std::uint32_t begin = 0; begin < scan.header.points; begin += kBlock) {
    const std::uint32_t end = std::min(scan.header.points, begin + kBlock);
    std::uint32_t located = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
      const rt::ScanPoint& point = scan.points[i];
      const rt::Vector3 p{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                          static_cast<double>(point.z_m)};
      const double range2 = dot(p, p);
      if (!std::isfinite(range2)) {  // floats squared in double cannot overflow
        ++counts.not_finite;
      } else if (range2 < near2) {
        ++counts.too_near;
      } else if (range2 > far2) {
        ++counts.too_far;
      } else if (!locate(r * p + pose.p_world_sensor_m, block[located])) {
        ++counts.out_of_grid;
      } else {
        table_.prefetch(block[located].place);
        ++located;
      }
    }
    for (std::uint32_t i = 0; i < located; ++i) place_point(block[i], tick32, result);
  }
  finish_scan();
  output_.stamp_ns = scan.header.stamp_ns;
  add_counts(counts);
  if (counts.pool_full > 0) result.status = Status::full;
  return result;
}

/// Cell and offset of a point; false outside the grid. The range is asked before any conversion to a whole
/// number.
bool VoxelGrid::locate(const rt::Vector3& p_world_m, Located& out) const {
  const rt::Vector3 u = inverse_size_ * p_world_m;
  const bool inside =
      std::fabs(u.x) < kCellLimit && std::fabs(u.y) < kCellLimit && std::fabs(u.z) < kCellLimit;
  if (!inside) return false;
  const rt::Vector3 low{std::floor(u.x), std::floor(u.y), std::floor(u.z)};
  const Cell cell{static_cast<std::int32_t>(low.x), static_cast<std::int32_t>(low.y),
                  static_cast<std::int32_t>(low.z)};
  out.key = cell.key();
  out.offset[0] = offset_step(u.x - low.x);
  out.offset[1] = offset_step(u.y - low.y);
  out.offset[2] = offset_step(u.z - low.z);
  out.place = table_.place(out.key);
  out.p_world_m = p_world_m;
  return true;
}

void VoxelGrid::place_point(const Located& point, std::uint32_t tick, InsertResult& result) {
  std::uint32_t index = find_key(point.key, point.place);
  if (index == kNoVoxel) {
    index = make_room(point, result);
    if (index == kNoVoxel) {
      ++result.points.pool_full;
      return;
    }
    pool_[index] = Voxel{};
    pool_[index].key = point.key;
    ++result.points.created;
  }
  touch(index);
  pool_[index].add(point.offset, tick);
  ++result.points.used;
}

/// A slot of the pool for a new cell, entered in the table; kNoVoxel when there is none.
std::uint32_t VoxelGrid::make_room(const Located& point, InsertResult& result) {
  if (!table_.has_room(point.place)) return kNoVoxel;
  if (output_.voxels < pool_.size()) {
    const std::uint32_t index = output_.voxels++;
    output_.high_water = std::max(output_.high_water, output_.voxels);
    (void)table_.add(point.place, index);
    return index;
  }
  if (config_.full_policy == FullPolicy::refuse) return kNoVoxel;

  std::uint32_t victim = kNoVoxel;
  double farthest = squared_distance(point.p_world_m, sensor_m_);
  const auto window = static_cast<std::uint32_t>(std::min<std::size_t>(kEvictionWindow, pool_.size()));
  for (std::uint32_t i = 0; i < window; ++i) {
    const std::uint32_t index = hand_;
    hand_ = hand_ + 1 < pool_.size() ? hand_ + 1 : 0;
    if (pool_[index].next_touched != Voxel::kUntouched) continue;
    const double distance = squared_distance(centre_of(pool_[index].key, config_.voxel_size_m), sensor_m_);
    if (distance > farthest) {
      farthest = distance;
      victim = index;
    }
  }
  if (victim == kNoVoxel) return kNoVoxel;
  output_.map_digest -= pool_[victim].digest();
  (void)table_.remove(table_.place(pool_[victim].key), victim);
  (void)table_.add(point.place, victim);
  ++result.points.evicted;
  return victim;
}

/// Notes that the scan changes a voxel; its digest leaves the sum until finish_scan().
void VoxelGrid::touch(std::uint32_t index) {
  Voxel& voxel = pool_[index];
  if (voxel.next_touched != Voxel::kUntouched) return;
  if (voxel.count > 0) output_.map_digest -= voxel.digest();
  voxel.next_touched = first_touched_;
  first_touched_ = index;
}

void VoxelGrid::finish_scan() {
  while (first_touched_ != kNoVoxel) {
    Voxel& voxel = pool_[first_touched_];
    first_touched_ = voxel.next_touched;
    voxel.next_touched = Voxel::kUntouched;
    output_.map_digest += voxel.digest();
  }
}

InsertResult VoxelGrid::refuse_scan(const rt::PointScan& scan, Status why) {
  InsertResult result{why, {}};
  result.points.in = scan.header.points;
  result.points.bad_pose = scan.header.points;
  add_counts(result.points);
  return result;
}

void VoxelGrid::add_counts(const VoxelGridCounts& counts) {
  VoxelGridCounts& sum = output_.points;
  sum.in += counts.in;
  sum.used += counts.used;
  sum.not_finite += counts.not_finite;
  sum.too_near += counts.too_near;
  sum.too_far += counts.too_far;
  sum.out_of_grid += counts.out_of_grid;
  sum.pool_full += counts.pool_full;
  sum.bad_pose += counts.bad_pose;
  sum.created += counts.created;
  sum.evicted += counts.evicted;
  ++output_.scans;
  output_.change_digest = mix64(output_.change_digest ^ mix64(output_.map_digest + output_.scans));
}

std::uint32_t VoxelGrid::find_key(std::uint64_t key, const VoxelTable::Place& place) const {
  return table_.find(key, place, [this](std::uint32_t index) { return pool_[index].key; });
}

std::uint32_t VoxelGrid::find(const rt::Vector3& p_world_m) const {
  Located point;
  if (!usable_ || !is_finite(p_world_m) || !locate(p_world_m, point)) return kNoVoxel;
  return find_key(point.key, point.place);
}

VoxelView VoxelGrid::voxel(std::uint32_t n) const {
  const Voxel& v = pool_[n];
  const Cell cell = Cell::from_key(v.key);
  const double scale = 1.0 / (static_cast<double>(v.count) * Voxel::kOffsetSteps);
  const double half = 0.5 / Voxel::kOffsetSteps;  // offsets were cut down to whole steps
  const rt::Vector3 mean{cell.x + v.offset_sum[0] * scale + half, cell.y + v.offset_sum[1] * scale + half,
                         cell.z + v.offset_sum[2] * scale + half};
  return {config_.voxel_size_m * mean, v.count, v.last_tick, v.key};
}

std::span<const std::uint32_t> VoxelGrid::in_key_order(std::span<std::uint32_t> scratch) const {
  if (scratch.size() < size()) return {};
  const std::span<std::uint32_t> order = scratch.first(size());
  for (std::uint32_t i = 0; i < size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [this](std::uint32_t a, std::uint32_t b) { return pool_[a].key < pool_[b].key; });
  return order;
}

std::uint64_t VoxelGrid::recompute_digest() const {
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < size(); ++i) sum += pool_[i].digest();
  return sum;
}

}  // namespace sortie::mapping
