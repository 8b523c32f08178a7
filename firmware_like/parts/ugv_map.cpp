// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's local map: its task, from sweeps and poses to voxels, normals and segments.
#include <algorithm>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/segment_report.hpp"
#include "firmware_like/runtime/live_keys.hpp"
#include "firmware_like/runtime/owned_part.hpp"
#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {
namespace {

constexpr std::uint32_t kUsualUnits = 65'536;
constexpr double kMostCells = 4;  // that a neighbourhood reaches

mapping::RollingGridConfig read_grid(Profile& profile) {
  mapping::RollingGridConfig c;
  c.max_range_m = 30;
  profile.read("map", c);
  if (c.max_range_m <= c.min_range_m) profile.fail("map.max_range_m", "must be above map.min_range_m");
  for (const char* path : {"map.radius_m", "map.half_height_m"}) {
    const double cells = (path[4] == 'r' ? c.radius_m : c.half_height_m) / c.voxel_size_m;
    if (cells < 4 || cells > 1000) profile.fail(path, "must be 4 to 1000 voxels (map.voxel_m)");
  }
  return c;
}

void read_segments(Profile& profile, ChosenMapConfig& c) {
  const double edge_m = c.grid.voxel_size_m;
  c.by = SegmentsBy::euclidean;
  c.segments.radius_m = 2 * edge_m;
  c.most_segments = 1024;
  c.normals.radius_m = 3 * edge_m;
  c.normals.restate_m = 0.3 * edge_m;
  c.most_angle_rad = 4 * kDegree;
  c.voxels = 1 << 17;
  profile.read("map", c);
  const auto check = [&](const char* path, double radius_m) {
    if (radius_m > kMostCells * edge_m) profile.fail(path, "must be at most 4 voxels (map.voxel_m)");
  };
  check("map.growing_radius_m", c.segments.radius_m);
  check("map.normal_radius_m", c.normals.radius_m);
  c.voxels = c.voxels / 4 * 4;
  if (c.blocks == 0) c.blocks = std::min(c.voxels / 4, 65'534u);
}

// Map, its pools, what sweeps are, and where the lidar sits.
struct UgvMapConfig {
  ChosenMapConfig map;
  LidarSweepsConfig sweeps;
  bool publish{};   // lists of segments
  bool features{};  // in them
  bool anytime{};   // the segmenter stops when the task's units are spent
};

UgvMapConfig read_map_config(Profile& profile) {
  profile.knob("groups.mapping.rate_hz");
  UgvMapConfig config;
  ChosenMapConfig& map = config.map;
  map.grid = read_grid(profile);
  read_segments(profile, map);
  config.sweeps = read_sweeps(profile, map.grid.min_range_m, map.grid.max_range_m);
  map.scan_points = config.sweeps.scans.points;
  const std::string publish = profile.text("map.publish", "segments",
                                           "of segments, over LCM: nothing; ids, sizes and events; or also "
                                           "places, boxes and features of their eigenvalues",
                                           {"off", "segments", "features"});
  config.publish = publish != "off" && map.by != SegmentsBy::off;
  config.features = config.publish && publish == "features";
  config.anytime = profile.flag("map.anytime", false, "segments wait when the units of task map are spent") &&
                   map.by != SegmentsBy::off;
  return config;
}

/// The map's clock: the same live and replayed, whatever the run's epoch was.
rt::Tick milliseconds_of(const rt::JobContext& context) {
  return context.job * static_cast<std::uint64_t>(context.period_ns) / 1'000'000u;
}

/// What became of every return. in = used + all others.
struct MapPoints : mapping::SweepCounts, mapping::GridRefusals {
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
  explicit UgvMap(VehicleBuilder& builder) {
    const rt::GroupId group = builder.group("mapping", 10);
    UgvMapConfig config = read_map_config(builder.profile());
    anytime_ = config.anytime;
    config.map.segments.units = anytime_ ? kQuantum : 0;
    whole_ = !anytime_ && config.map.normals.solves == 0;
    sweeps_ = std::make_unique<LidarSweeps>(builder, group, config.sweeps);
    map_ = std::make_unique<ChosenMap>(config.map, builder.arena());
    builder.offer(*map_);
    if (rt::kBuilt<"segment_lists"> && config.publish) {
      lists_ = builder.reports<rt::SegmentList>("segments", 4);
      builder.offer(*lists_);
      report_ = std::make_unique<SegmentReport>(config.map, config.features, *lists_, builder.arena());
    }
    // Pools and the size of a voxel are memory; how far the lidar is believed may change.
    live_keys<mapping::RollingGridConfig>(builder, group, "map", *this);
    add_task(builder, group);
    add_counters(builder, config.map);
  }

  void finish(VehicleBuilder& builder) override { builder.chain({"scan_to_map", {"SCAN", "map"}}); }
  drivers::ScanSink* scan_sink() override { return sweeps_->port(); }
  void for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const override {
    map_->for_each_voxel(put);
  }

  const mapping::RollingGridConfig& config() const { return map_->grid().config(); }
  /// As those of grid and sweeps, both at once.
  Status set_ranges(double min_m, double max_m) {
    const Status status = map_->grid().set_ranges(min_m, max_m);
    return status == Status::ok ? sweeps_->set_ranges(min_m, max_m) : status;
  }

 private:
  static constexpr std::uint32_t kQuantum = 256;  ///< units of the segmenter between two looks

  void add_task(VehicleBuilder& builder, rt::GroupId group) {
    const rt::TaskBase* task = builder.task<MapOutput>(
        group, "map", TaskDefaults{50'000, rt::Criticality::b, anytime_ ? kUsualUnits : 0},
        [this](rt::JobContext& context, MapOutput& output) {
          sweeps_->begin(context);
          for (std::uint32_t i = 0; i < sweeps_->size(); ++i) {
            context.add_units((*sweeps_)[i].header.points);
            take(i, milliseconds_of(context));
          }
          segment(context);
          output = output_;
        });
    // What a budget left undone is no part of the archived state.
    if (!whole_) return;
    builder.remembers(task, *map_, output_, *sweeps_);
  }

  void add_counters(VehicleBuilder& builder, const ChosenMapConfig& config) {
    const mapping::RollingGridOutput& grid = map_->grid().output();
    const MapOutput& output = output_;
    builder.pool("voxels", [&grid, &output, size = std::uint64_t{config.voxels}] {
      return PoolLevel{size, std::uint64_t{grid.most_chunks} * mapping::Block::kChunk,
                       output.points.pool_full};
    });
    builder.pool("blocks", [&grid, size = std::uint64_t{config.blocks}] {
      return PoolLevel{size, grid.most_blocks, grid.points.forced};
    });
    if (map_->has_normals()) {
      builder.pool("normals", [&grid, size = std::uint64_t{config.voxels}] {
        return PoolLevel{size, std::uint64_t{grid.most_chunks} * mapping::Block::kChunk, 0};
      });
    }
    builder.counters("points_", output_.points);
    builder.counter("scans", [&output] { return output.scans; });
    builder.uses("SCAN", [&output] { return output.scans - output.scans_unplaced; });
    builder.counter("scans_unplaced", [&output] { return output.scans_unplaced; });
    builder.counter("map_voxels", [&output] { return std::uint64_t{output.voxels}; });
    if (map_->labelling() == nullptr) return;
    const ChosenMap& map = *map_;
    builder.pool("fragments", [&map] {
      return PoolLevel{map.fragment_capacity(), map.graph()->most_in_use(), map.graph()->refused()};
    });
    builder.counter("segments", [&output] { return std::uint64_t{output.segments.segments}; });
    builder.counters("segments_", output.segments.lives);
    builder.counter("segments_refused", [&map] { return map.labelling()->counts().slots_full; });
    builder.counter("segment_backlog", [&output] { return std::uint64_t{output.segments.backlog}; });
    builder.counter("segment_events_lost",
                    [&map] { return map.labelling()->counts().events_lost + map.events_unseen(); });
  }

  void take(std::uint32_t index, rt::Tick tick) {
    const rt::ScanHeader& header = (*sweeps_)[index].header;
    const mapping::StraightSweep& placed = sweeps_->place(index);
    ++output_.scans;
    MapPoints& points = output_.points;
    rt::add_fields<mapping::SweepCounts>(placed.counts, points);
    if (placed.status != Status::ok) {
      ++output_.scans_unplaced;
      return;
    }
    const mapping::RollingInsert inserted = map_->insert(placed.scan, placed.pose, tick);
    rt::add_fields<mapping::PointCounts>(inserted.points, points);
    rt::add_fields<mapping::GridRefusals>(inserted.points, points);
    // The grid was given what straightening used: such a return came in once, and its end is the grid's.
    points.used -= placed.counts.used;
    points.in -= inserted.points.in;
    output_.stamp_ns = header.stamp_ns;
  }

  void segment(rt::JobContext& context) {
    while (!map_->done() && (!anytime_ || context.spend(kQuantum))) {
      map_->segment(milliseconds_of(context));
      if (rt::kBuilt<"segment_lists"> && report_) report_->note(*map_);
    }
    if (rt::kBuilt<"segment_lists"> && report_) report_->send(*map_, output_.stamp_ns);
    const mapping::RollingGridOutput& grid = map_->grid().output();
    output_.voxels = grid.voxels;
    output_.blocks = grid.blocks;
    output_.created = grid.points.created;
    output_.evicted = grid.points.evicted;
    output_.forced = grid.points.forced;
    output_.normals_backlog = map_->normals_backlog();
    output_.segments = map_->summary();
    output_.change_digest = map_->change_digest();
  }

  std::unique_ptr<LidarSweeps> sweeps_;
  std::unique_ptr<ChosenMap> map_;
  OwnedPart<SegmentReport, "segment_lists"> report_;     ///< null: no list of segments is published
  std::unique_ptr<ReportQueue<rt::SegmentList>> lists_;  ///< offered, for one reader on another thread
  MapOutput output_;
  bool anytime_{};
  bool whole_{};  ///< no budget leaves anything for a later job
};

}  // namespace

std::unique_ptr<Part> make_map(VehicleBuilder& builder) { return std::make_unique<UgvMap>(builder); }

}  // namespace sortie::firmware
