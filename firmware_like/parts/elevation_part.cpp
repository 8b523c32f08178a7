// SPDX-License-Identifier: BSD-3-Clause
// The heights of the ground around the robot, from its lidar's scans and its odometry.
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part_access.hpp"

namespace sortie::firmware {
namespace {

struct ElevationPartConfig {
  double drift_m{0.014};

  SORTIE_KEYS(c, key) {
    key("drift_m", c.drift_m,
        {0.0001, 1, "m", "what the odometry's height may be off by after 10 m of way: old heights get less sure"});
  }
};

/// Group `mapping`, task `elevation`: all scans of a job into the map.
class ElevationPart final : public Part {
 public:
  explicit ElevationPart(VehicleBuilder& builder) {
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
    builder.uses("SCAN", [this] { return scans_; });
  }

  drivers::ScanSink* scan_sink() override { return own_ != nullptr ? own_->port() : nullptr; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "elevation")
        .base<Part>()
        .fixed(config_, sweeps_, access_)
        .by_hand(own_, map_)
        .state(has_place_, last_m_, scans_, unplaced_);
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
    const rt::Vector3 p_m = placed.pose.p;
    const double way_m = has_place_ ? rt::norm(p_m - last_m_) : 0.0;
    has_place_ = true;
    last_m_ = p_m;
    // Finite, as the sweep is placed; what does not fit is counted as lost.
    static_cast<void>(map_->centre_on(p_m));
    static_cast<void>(map_->add_variance(0.1 * way_m * config_.drift_m * config_.drift_m));
    static_cast<void>(map_->update(placed.scan, {p_m, placed.pose.q}));
    ++scans_;
    context.add_units(placed.scan.header.points);
  }

  ElevationPartConfig config_;
  LidarSweeps* sweeps_{};
  std::unique_ptr<LidarSweeps> own_;  // null where another part has them
  std::unique_ptr<mapping::ElevationMap> map_;
  ElevationAccess access_;
  bool has_place_{};
  rt::Vector3 last_m_;
  std::uint64_t scans_{};
  std::uint64_t unplaced_{};
};

}  // namespace

std::unique_ptr<Part> make_elevation(VehicleBuilder& builder) {
  return std::make_unique<ElevationPart>(builder);
}

}  // namespace sortie::firmware
