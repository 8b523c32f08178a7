// SPDX-License-Identifier: BSD-3-Clause
// The heights of the ground around the robot, from its lidar's scans and its odometry.
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/elevation/veil.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {
namespace {

struct ElevationPartConfig {
  double drift_m{0.014};
  double veil_rad{3.0 * rt::kDegInRad.kept};

  SORTIE_KEYS(c, key) {
    key("drift_m", c.drift_m,
        {0.0001, 1, "m",
         "what the odometry's height may be off by after 10 m of way: old heights get less sure"});
    key("veil_deg", c.veil_rad,
        {0, 45, rt::kDegInRad,
         "returns that hang between an edge and what lies behind it, along a beam but for this angle, are "
         "left "
         "out; 0: they are not"});
  }
};

/// Group `mapping`, task `elevation`: all scans of a job into the map. Where the scene has `locate` heights
/// are in the frame of its map, else in the odometry's.
class ElevationPart final : public Part {
 public:
  explicit ElevationPart(VehicleBuilder& builder) : located_(builder.find<LocateAccess>()) {
    Profile& profile = builder.profile();
    const rt::GroupId group = builder.group("mapping", 10);
    mapping::ElevationConfig config;
    profile.read("elevation", config);
    profile.read("elevation", config_);
    profile.check_power_of_two("elevation.cells", static_cast<std::uint32_t>(config.size));
    if (config.max_range_m <= config.min_range_m)
      profile.fail("elevation.max_range_m", "must be above elevation.min_range_m");
    sweeps_ = builder.find<LidarSweeps>();
    if (sweeps_ == nullptr) {
      own_ = std::make_unique<LidarSweeps>(builder, group,
                                           read_sweeps(profile, config.min_range_m, config.max_range_m));
      sweeps_ = own_.get();
    } else {
      sweeps_->share(builder, config.min_range_m, config.max_range_m);
    }
    map_ = std::make_unique<mapping::ElevationMap>(config, builder.arena());
    if (!map_->usable() && builder.arena().refused() == 0)
      profile.fail("elevation.cells", "no window of this size can be kept with cells of this size");
    if (config_.veil_rad > 0.0)
      kept_ = builder.arena().make_array<rt::ScanPoint>("without veils", sweeps_->points());
    access_.map = map_.get();
    builder.offer(access_);
    const auto* task = builder.task<mapping::ElevationOutput>(
        group, "elevation", TaskDefaults{10'000, rt::Criticality::b},
        [this](rt::JobContext& context, mapping::ElevationOutput& output) {
          sweeps_->begin(context);
          for (std::uint32_t i = 0; i < sweeps_->size(); ++i) take(context, i);
          output = map_->output();
        });
    builder.remembers(task, *this);
    const mapping::ElevationOutput& counts = map_->output();
    builder.counter("elevation_used", [&counts] { return counts.used; });
    builder.counter("elevation_outside", [&counts] { return counts.outside; });
    builder.counter("elevation_lost", [&counts] { return counts.lost; });
    builder.counter("elevation_unplaced", [this] { return unplaced_; });
    builder.counter("elevation_veiled", [this] { return veiled_; });
    builder.uses("SCAN", [this] { return scans_; });
  }

  drivers::ScanSink* scan_sink() override { return own_ != nullptr ? own_->port() : nullptr; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "elevation")
        .base<Part>()
        .fixed(config_, located_, sweeps_, access_)
        .scratch(kept_)
        .by_hand(own_, map_)
        .state(has_place_, last_m_, scans_, unplaced_, veiled_);
    archive.value(*map_);
    if (own_ != nullptr) archive.value(*own_);  // else they are another part's
  }

 private:
  void take(rt::JobContext& context, std::uint32_t index) {
    const mapping::StraightSweep& placed = sweeps_->place(index);
    if (placed.status != Status::ok) {
      ++unplaced_;
      return;
    }
    mapping::RigidPose T_world_sensor = placed.pose;
    if (located_ != nullptr) {
      const mapping::Located& located = located_->locator->located();
      if (!mapping::is_placed(located.verdict)) {
        ++unplaced_;
        return;
      }
      T_world_sensor = mapping::after(located.T_map_odom, placed.pose);
    }
    const rt::Vector3 p_m = T_world_sensor.p;
    const double way_m = has_place_ ? rt::norm(p_m - last_m_) : 0.0;
    has_place_ = true;
    last_m_ = p_m;
    // Finite, as the sweep is placed; what does not fit is counted as lost.
    static_cast<void>(map_->centre_on(p_m));
    static_cast<void>(map_->add_variance(0.1 * way_m * config_.drift_m * config_.drift_m));
    rt::PointScan scan = placed.scan;
    if (!kept_.empty()) {
      const std::size_t kept =
          mapping::without_veils({scan.points, scan.header.points}, rt::tan(config_.veil_rad), kept_);
      veiled_ += scan.header.points - kept;
      scan.header.points = static_cast<std::uint32_t>(kept);
      scan.points = kept_.data();
    }
    static_cast<void>(map_->update(scan, {p_m, T_world_sensor.q}));
    ++scans_;
    context.add_units(placed.scan.header.points);
  }

  ElevationPartConfig config_;
  LocateAccess* located_;  // null: the odometry's frame is the world's
  LidarSweeps* sweeps_{};
  std::unique_ptr<LidarSweeps> own_;  // null where another part has them
  std::unique_ptr<mapping::ElevationMap> map_;
  ElevationAccess access_;
  bool has_place_{};
  rt::Vector3 last_m_;
  std::uint64_t scans_{};
  std::uint64_t unplaced_{};
  std::uint64_t veiled_{};
  std::span<rt::ScanPoint> kept_;  // of one scan
};

}  // namespace

std::unique_ptr<Part> make_elevation(VehicleBuilder& builder) {
  return std::make_unique<ElevationPart>(builder);
}

}  // namespace sortie::firmware
