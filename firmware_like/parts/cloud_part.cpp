// SPDX-License-Identifier: BSD-3-Clause
// The cloud that the vehicle's lidar or camera makes: cells, each with where it was seen from. Another robot
// is placed on it, or it on another robot's.
#include <algorithm>

#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::firmware {
namespace {

using mapping::after;
using mapping::inverse;
using mapping::RigidPose;

struct CloudPartConfig {
  double view_move_m{0.3};
  double view_turn_rad{0.17};
  double min_range_m{0.5};
  double max_range_m{20.0};
  std::uint32_t stride{1};

  SORTIE_KEYS(c, key) {
    key("view_move_m", c.view_move_m, {0, 10, "m", "a scan is a view where the sensor has moved so far,"});
    key("view_turn_deg", c.view_turn_rad, {0, 180, rt::kDegInRad, "or has turned so far, since the last"});
    key("min_range_m", c.min_range_m, {0, 100, "m", "nearer returns are left out"});
    key("max_range_m", c.max_range_m, {0.1, 1000, "m", "farther returns are left out"});
    key("stride", c.stride, {1, 64, "", "of the returns of a view, one in so many"});
  }
};

struct CloudOutput {
  std::uint64_t views{};
  std::uint64_t points{};
  std::uint64_t held{};      ///< views that came while the cloud was being matched
  std::uint64_t unplaced{};  ///< scans that nobody knows the place of
  std::uint64_t no_room{};   ///< points whose cells found no room, or lie too far off
  std::uint32_t cells{};     ///< with points, so far
  SORTIE_FIELDS(views, points, held, unplaced, no_room, cells)
};

/// Group `mapping`, task `cloud`. Where the scene has `locate` the cloud is in the frame of its map, else in
/// the odometry's.
class CloudPart final : public Part {
 public:
  explicit CloudPart(VehicleBuilder& builder) : located_(builder.find<LocateAccess>()) {
    Profile& profile = builder.profile();
    const rt::GroupId group = builder.group("mapping", 10);
    profile.read("cloud", config_);
    if (config_.max_range_m <= config_.min_range_m)
      profile.fail("cloud.max_range_m", "must be above cloud.min_range_m");
    const bool camera =
        profile.text(
            "cloud.sensor", "laser",
            "laser: ranges good to some cm; camera: to 1 % of the range, and holes where nothing has texture",
            {"laser", "camera"}) == "camera";
    access_.cloud.sensor = camera ? mapping::CloudSensor::camera : mapping::CloudSensor::laser;
    mapping::SightConfig sight = mapping::sight_config(access_.cloud.sensor);
    profile.read("cloud", sight);
    profile.check_power_of_two("cloud.window_cells", sight.window_cells);
    profile.check_power_of_two("cloud.window_cells_up", sight.window_cells_up);
    sweeps_ = builder.find<LidarSweeps>();
    if (sweeps_ == nullptr) {
      refuse_second_reader(builder);
      own_ = std::make_unique<LidarSweeps>(builder, group,
                                           read_sweeps(profile, config_.min_range_m, config_.max_range_m));
      sweeps_ = own_.get();
    } else {
      sweeps_->share(builder, config_.min_range_m, config_.max_range_m);
    }
    layer_ = std::make_unique<mapping::SightLayer>(sight, builder.arena());
    points_ = builder.arena().make_array<rt::Vector3>("view", sight.points);
    access_.cloud.layer = layer_.get();
    builder.offer(access_);
    const auto* task = builder.task<CloudOutput>(group, "cloud", TaskDefaults{20'000, rt::Criticality::b},
                                                 [this](rt::JobContext& context, CloudOutput& output) {
                                                   work(context);
                                                   output = output_;
                                                 });
    builder.remembers(task, *this);
    builder.counters("cloud_", output_);
    builder.uses("SCAN", [this] { return output_.views; });
  }

  drivers::ScanSink* scan_sink() override { return own_ != nullptr ? own_->port() : nullptr; }
  const mapping::SensedCloud* cloud() const override { return &access_.cloud; }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "cloud")
        .base<Part>()
        .fixed(config_, located_, sweeps_, points_)
        .by_hand(own_, layer_, access_)
        .state(has_view_, last_view_, output_);
    archive.value(*layer_);
    archive.value(access_.views);
    archive.value(access_.held);
    archive.value(access_.renew);
    if (own_ != nullptr) archive.value(*own_);  // else they are another part's
    mapping::check_pose(archive, last_view_);
  }

 private:
  // A multirotor with a sensed map has a reader of its own.
  static void refuse_second_reader(VehicleBuilder& builder) {
    const auto& ports = builder.ports();
    if (std::none_of(ports.begin(), ports.end(), [](const auto& port) { return port->channel() == "SCAN"; }))
      return;
    builder.profile().fail(
        "tasks.cloud.enabled",
        "another part reads the scans already; choose a flight_map.source other than \"lidar\"");
  }

  void work(rt::JobContext& context) {
    sweeps_->begin(context);
    if (access_.renew && !access_.held) {
      access_.renew = false;
      access_.views = 0;
      has_view_ = false;
      layer_->clear();
    }
    for (std::uint32_t i = 0; i < sweeps_->size(); ++i) take(context, i);
    output_.cells = static_cast<std::uint32_t>(layer_->size());
    output_.no_room = layer_->counts().pool_full + layer_->counts().outside;
  }

  /// Where the sensor was: on the map, where there is one.
  bool place(const mapping::StraightSweep& placed, RigidPose& T_cloud_sensor) const {
    if (placed.status != Status::ok) return false;
    T_cloud_sensor = placed.pose;
    if (located_ == nullptr) return true;
    const mapping::Located& located = located_->locator->located();
    if (!mapping::is_placed(located.verdict)) return false;
    T_cloud_sensor = after(located.T_map_odom, placed.pose);
    return true;
  }

  void take(rt::JobContext& context, std::uint32_t index) {
    const mapping::StraightSweep& placed = sweeps_->place(index);
    RigidPose T_cloud_sensor;
    if (!place(placed, T_cloud_sensor)) {
      ++output_.unplaced;
      return;
    }
    const RigidPose moved = after(inverse(last_view_), T_cloud_sensor);
    if (has_view_ && rt::norm(moved.p) < config_.view_move_m &&
        rt::norm(rt::log_rotation(moved.q)) < config_.view_turn_rad)
      return;
    if (access_.held) {
      ++output_.held;
      return;
    }
    has_view_ = true;
    last_view_ = T_cloud_sensor;
    ++output_.views;
    ++access_.views;
    context.add_units(placed.scan.header.points / config_.stride);
    enter(placed.scan, T_cloud_sensor);
  }

  void enter(const rt::PointScan& scan, const RigidPose& T_cloud_sensor) {
    std::size_t count = 0;
    const auto flush = [&] {
      // Finite, and no more than there is room for: not refused.
      if (count > 0) static_cast<void>(layer_->insert(points_.first(count), T_cloud_sensor.p));
      output_.points += count;
      count = 0;
    };
    for (std::uint32_t i = 0; i < scan.header.points; i += config_.stride) {
      const rt::ScanPoint& point = scan.points[i];
      const rt::Vector3 seen{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                             static_cast<double>(point.z_m)};
      const double range_m = rt::norm(seen);
      if (!(range_m >= config_.min_range_m && range_m <= config_.max_range_m)) continue;
      points_[count++] = T_cloud_sensor.p + rt::rotate(T_cloud_sensor.q, seen);
      if (count == points_.size()) flush();
    }
    flush();
  }

  CloudPartConfig config_;
  LocateAccess* located_;
  LidarSweeps* sweeps_{};
  std::unique_ptr<LidarSweeps> own_;  // null where another part has them
  std::unique_ptr<mapping::SightLayer> layer_;
  std::span<rt::Vector3> points_;  // of a part of a view
  CloudAccess access_;
  bool has_view_{};
  RigidPose last_view_;
  CloudOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_cloud(VehicleBuilder& builder) { return std::make_unique<CloudPart>(builder); }

}  // namespace sortie::firmware
