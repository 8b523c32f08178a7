// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's local map: its task, from sweeps and poses to voxels, normals and segments.
#pragma once

#include <memory>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/segment_report.hpp"
#include "firmware_like/runtime/owned_part.hpp"

namespace sortie::firmware {

/// What became of every return. in = used + all others.
struct MapPoints {
  std::uint64_t in{};
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t on_robot{};
  std::uint64_t unplaced{};     ///< no pose for the scan, or none so old for the return
  std::uint64_t outside{};      ///< of the local map
  std::uint64_t out_of_grid{};  ///< of scans taken farther from the origin than the grid reaches
  std::uint64_t pool_full{};
  std::uint64_t scan_full{};
  std::uint64_t bad_pose{};
  SORTIE_FIELDS(in, used, not_finite, too_near, too_far, on_robot, unplaced, outside, out_of_grid, pool_full,
                scan_full, bad_pose)
};

/// What the task puts out.
struct MapOutput {
  rt::Nanoseconds stamp_ns{};      ///< of the newest scan that was placed
  std::uint64_t scans{};           ///< taken, placed or not
  std::uint64_t scans_unplaced{};  ///< no pose at their stamp
  MapPoints points;
  std::uint32_t voxels{};
  std::uint32_t blocks{};
  std::uint64_t created{};          ///< voxels
  std::uint64_t evicted{};          ///< voxels
  std::uint64_t forced{};           ///< blocks that gave way in a full pool
  std::uint32_t normals_backlog{};  ///< blocks whose normals wait
  SegmentSummary segments;
  std::uint64_t change_digest{};  ///< see ChosenMap
  SORTIE_FIELDS(stamp_ns, scans, scans_unplaced, points, voxels, blocks, created, evicted, forced,
                normals_backlog, segments, change_digest)
};

/// Group `mapping`, task `map`. Scans go in as LidarSweeps has them; one for which there is no pose is
/// refused and counted. Units of the task: one for each return, and the segmenter's.
class UgvMap final : public Part {
 public:
  explicit UgvMap(VehicleBuilder& builder);

  void finish(VehicleBuilder& builder) override { builder.chain({"scan_to_map", {"SCAN", "map"}}); }
  drivers::ScanSink* scan_sink() override { return sweeps_->port(); }
  void for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const override {
    map_->for_each_voxel(put);
  }

  const mapping::RollingGridConfig& config() const { return map_->grid().config(); }
  /// As those of grid and sweeps, both at once.
  Status set_ranges(double min_m, double max_m);

 private:
  static constexpr std::uint32_t kQuantum = 256;  ///< units of the segmenter between two looks

  void add_task(VehicleBuilder& builder, rt::GroupId group);
  void add_counters(VehicleBuilder& builder, const ChosenMapConfig& config);
  void take(std::uint32_t index, rt::Tick tick);
  void count(const mapping::RollingGridCounts& points);
  void segment(rt::JobContext& context);

  std::unique_ptr<LidarSweeps> sweeps_;
  std::unique_ptr<ChosenMap> map_;
  OwnedPart<SegmentReport, "segment_lists"> report_;     ///< null: no list of segments is published
  std::unique_ptr<ReportQueue<rt::SegmentList>> lists_;  ///< offered, for one reader on another thread
  MapOutput output_;
  bool anytime_{};
  bool whole_{};  ///< no budget leaves anything for a later job
};

}  // namespace sortie::firmware
