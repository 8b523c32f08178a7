// SPDX-License-Identifier: BSD-3-Clause
// A map of what the lidar hit: a voxel grid of fixed memory that takes posed scans.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/voxel.hpp"
#include "mapping/voxel_table.hpp"
#include "rt/archive.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::mapping {

/// What happens to a point of a new cell when the pool is full.
enum class FullPolicy : std::uint8_t {
  refuse,          ///< the point is refused; points of known cells still go in
  evict_farthest,  ///< a far, old voxel gives way: of the next 16 in the pool the one farthest from the
                   ///< sensor, if it is farther than the new point and not part of the present scan; else the
                   ///< point is refused
};

/// Settings of the grid.
struct VoxelGridConfig {
  double voxel_size_m{0.1};
  double min_range_m{0.5};   ///< nearer points (the robot itself, missing returns at 0) are refused
  double max_range_m{30.0};  ///< farther points are refused
  FullPolicy full_policy{FullPolicy::refuse};
};

/// Memory of a grid, which outlives it: value-initialised arrays. The pool's size is the capacity.
struct VoxelGridMemory {
  std::span<Voxel> pool;
  std::span<VoxelBucket> buckets;  ///< VoxelTable::buckets_for(pool.size())
};

/// What became of the points. in = used + all others but `created` and `evicted`.
struct VoxelGridCounts {
  std::uint64_t in{};
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t out_of_grid{};
  std::uint64_t pool_full{};
  std::uint64_t bad_pose{};  ///< all points of scans whose pose was not finite or no rotation
  std::uint64_t created{};   ///< voxels
  std::uint64_t evicted{};   ///< voxels

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("in", self.in);
    visit("used", self.used);
    visit("not_finite", self.not_finite);
    visit("too_near", self.too_near);
    visit("too_far", self.too_far);
    visit("out_of_grid", self.out_of_grid);
    visit("pool_full", self.pool_full);
    visit("bad_pose", self.bad_pose);
    visit("created", self.created);
    visit("evicted", self.evicted);
  }
};

/// State of the map as a task shows it: counts since start, and digests that any changed bit of any voxel
/// changes.
struct VoxelGridOutput {
  rt::Nanoseconds stamp_ns{};  ///< of the newest scan
  std::uint64_t scans{};       ///< scans given, good or not
  VoxelGridCounts points;
  std::uint32_t voxels{};
  std::uint32_t high_water{};     ///< most voxels so far
  std::uint64_t map_digest{};     ///< sum of the voxels' digests: of the whole map, in no order
  std::uint64_t change_digest{};  ///< chain over the changes of every scan so far

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("scans", self.scans);
    visit("points", self.points);
    visit("voxels", self.voxels);
    visit("high_water", self.high_water);
    visit("map_digest", self.map_digest);
    visit("change_digest", self.change_digest);
  }
};

/// Where the sensor was.
struct SensorPose {
  rt::Vector3 p_world_sensor_m;
  rt::Quaternion q_world_sensor;
};

/// What one scan did.
struct InsertResult {
  Status status{
      Status::ok};  ///< `full` when a point was refused for want of room; or why the whole scan was refused
  VoxelGridCounts points;  ///< of this scan only
};

/// One voxel as a reader sees it.
struct VoxelView {
  rt::Vector3 centroid_m;  ///< mean of its points, world
  std::uint32_t count{};
  std::uint32_t last_tick{};
  std::uint64_t key{};
};

/// Fixed-memory voxel grid: 32 bytes a voxel plus 16 to 32 of table; no heap. Cost: about 16 table entries
/// looked at for a point in the worst case, plus 16 voxels with evict_farthest. All coordinates in double.
class VoxelGrid {
 public:
  /// The grid takes nothing (status out_of_range) when a size or range is not positive and finite, or memory
  /// is empty.
  VoxelGrid(const VoxelGridConfig& config, const VoxelGridMemory& memory);

  /// Adds the points of a scan taken at `pose`.
  InsertResult insert(const rt::PointScan& scan, const SensorPose& pose, rt::Tick tick);

  /// Adds a scan at the pose that travels with it (kScanPosed).
  InsertResult insert(const rt::PointScan& scan, rt::Tick tick);

  /// Other ranges from the next scan on; what is in the map stays. `out_of_range` and no change unless
  /// 0 <= min < max, both finite.
  Status set_ranges(double min_m, double max_m);
  double min_range_m() const { return config_.min_range_m; }
  double max_range_m() const { return config_.max_range_m; }

  /// Counts and digests after the newest scan.
  const VoxelGridOutput& output() const { return output_; }

  /// Number of voxels, and any of them: n < size(). The order is that of creation until something is evicted.
  std::uint32_t size() const { return output_.voxels; }
  VoxelView voxel(std::uint32_t n) const;

  /// Looks a point's voxel up: its index, or kNoVoxel.
  std::uint32_t find(const rt::Vector3& p_world_m) const;

  /// The indices of all voxels in the order of their keys, in `scratch` (at least size() long; else empty).
  /// O(n log n), no heap: for exports and keyframes.
  std::span<const std::uint32_t> in_key_order(std::span<std::uint32_t> scratch) const;

  /// output().map_digest computed from nothing: O(n). Equal unless memory was damaged.
  std::uint64_t recompute_digest() const;

  /// The whole map to bytes and back, into a grid of the same configuration and capacity: 26 bytes a voxel,
  /// in the order of the pool, because eviction walks the pool. O(n). Between scans only.
  void archive(rt::Archive& archive);

 private:
  struct Located;
  bool locate(const rt::Vector3& p_world_m, Located& out) const;
  void place_point(const Located& point, std::uint32_t tick, InsertResult& result);
  std::uint32_t make_room(const Located& point, InsertResult& result);
  void touch(std::uint32_t index);
  void finish_scan();
  InsertResult refuse_scan(const rt::PointScan& scan, Status why);
  void add_counts(const VoxelGridCounts& counts);
  std::uint32_t find_key(std::uint64_t key, const VoxelTable::Place& place) const;

  VoxelGridConfig config_;
  double inverse_size_{};
  bool usable_{};
  std::span<Voxel> pool_;
  VoxelTable table_;
  std::uint32_t hand_{};                   ///< next voxel that may have to give way
  std::uint32_t first_touched_{kNoVoxel};  ///< list through Voxel::next_touched
  rt::Vector3 sensor_m_;
  VoxelGridOutput output_;
};

}  // namespace sortie::mapping
