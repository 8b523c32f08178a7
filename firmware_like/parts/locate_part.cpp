// SPDX-License-Identifier: BSD-3-Clause
// Where the robot is on a map of surfaces that it makes of its lidar's scans. The odometry hangs on that map
// by one transform and stays smooth.
#include <algorithm>

#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/lidar_sweeps.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/locator.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::firmware {
namespace {

using mapping::after;
using mapping::inverse;
using mapping::LocateVerdict;
using mapping::RigidPose;

// The message's own numbers, which programs read that know nothing of the map.
static_assert(rt::LocatedPose::kFirst == static_cast<int>(LocateVerdict::first) &&
              rt::LocatedPose::kAccepted == static_cast<int>(LocateVerdict::accepted) &&
              rt::LocatedPose::kNewPlace == static_cast<int>(LocateVerdict::new_place) &&
              rt::LocatedPose::kUnplaced == static_cast<int>(LocateVerdict::unplaced));

/// How far the odometry is believed from one placed scan to the next.
struct LocateConfig {
  bool scan_poses{true};
  bool start_on_map{};
  double sigma_move_m{0.02};
  double sigma_per_way{0.2};
  double sigma_turn_rad{0.01};
  double sigma_per_turn{0.1};

  SORTIE_KEYS(c, key) {
    key("scan_poses", c.scan_poses,
        {"poses that come with scans are the odometry; false: they are not read"});
    key("start_on_map", c.start_on_map,
        {"with a kept map the robot starts where that says it is; false: it waits until it is placed"});
    key("sigma_move_m", c.sigma_move_m,
        {0.001, 10, "m", "of the odometry since the scan that was placed last", rt::kKnob});
    key("sigma_per_way", c.sigma_per_way, {0, 1, "", "that much more for each metre of way", rt::kKnob});
    key("sigma_turn_deg", c.sigma_turn_rad, {0.01, 90, rt::kDegInRad, "the same of its turn"});
    key("sigma_per_turn", c.sigma_per_turn, {0, 1, "", "that much more for each degree of turn"});
  }
};

/// Group `mapping`, task `locate`: a job for each scan. Without odometry the motion of the scan before is
/// taken to go on, and scans are taken as they come.
class LocatePart final : public Part {
 public:
  explicit LocatePart(VehicleBuilder& builder) {
    const rt::GroupId group = builder.group("mapping", 10);
    mapping::RegistrationConfig config;
    builder.profile().read("locate", config);
    builder.profile().read("locate", config_);
    if (config.max_range_m <= config.min_range_m)
      builder.profile().fail("locate.max_range_m", "must be above locate.min_range_m");
    sweeps_ = builder.find<LidarSweeps>();
    if (sweeps_ == nullptr) {
      own_ = std::make_unique<LidarSweeps>(
          builder, group, read_sweeps(builder.profile(), config.min_range_m, config.max_range_m));
      sweeps_ = own_.get();
    } else {
      sweeps_->share(builder, config.min_range_m, config.max_range_m);
    }
    T_body_sensor_ = {sweeps_->config().p_body_sensor_m, sweeps_->config().q_body_sensor};
    const InitialPose& initial = builder.initial_pose();
    T_start_sensor_ = after({rt::to_vector(initial.p_world_body_m), rt::to_quaternion(initial.q_world_body)},
                            T_body_sensor_);
    builder.profile().read("locate", access_.memory);
    builder.profile().check_power_of_two("locate.window_cells", access_.memory.window_cells);
    builder.profile().check_power_of_two("locate.window_cells_up", access_.memory.window_cells_up);
    locator_ = std::make_unique<mapping::Locator>(config, builder.arena(), access_.memory);
    load_kept_map(builder, *locator_);
    access_.locator = locator_.get();
    builder.offer(access_);
    poses_ = builder.reports<rt::LocatedPose>("located", 16);
    builder.offer(*poses_);
    add_task(builder, group);
    add_counters(builder);
  }

  void finish(VehicleBuilder& builder) override { builder.chain({"scan_to_locate", {"SCAN", "locate"}}); }
  drivers::ScanSink* scan_sink() override { return own_ != nullptr ? own_->port() : nullptr; }
  const rt::Task<rt::LocatedPose>* located_task() const override { return task_; }
  const mapping::ScanRegistration* surfels() const override { return &locator_->registration(); }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "locate")
        .base<Part>()
        .fixed(config_, sweeps_, poses_, task_, T_body_sensor_, T_start_sensor_)
        .by_hand(own_, locator_)
        .scratch(access_)
        .state(T_odom_last_, unplaced_, output_);
    archive.value(*locator_);
    if (own_ != nullptr) archive.value(*own_);  // else they are the map's
    mapping::check_pose(archive, T_odom_last_);
  }

 private:
  void add_task(VehicleBuilder& builder, rt::GroupId group) {
    task_ = builder.task<rt::LocatedPose>(group, "locate", TaskDefaults{50'000, rt::Criticality::b},
                                          [this](rt::JobContext& context, rt::LocatedPose& output) {
                                            sweeps_->begin(context);
                                            access_.scans = 0;
                                            for (std::uint32_t i = 0; i < sweeps_->size(); ++i)
                                              take(context, i);
                                            output = output_;
                                          });
    builder.remembers(task_, *this);
  }

  void add_counters(VehicleBuilder& builder) {
    const mapping::LocateCounts& counts = locator_->located().counts;
    builder.counters("locate_", counts);
    builder.counter("locate_unplaced", [this] { return unplaced_; });
    builder.uses("SCAN", [&counts] {
      return counts.first + counts.accepted + counts.new_place + counts.unplaced_on_map;
    });
    static constexpr const char* kLayers[] = {"surfels_fine", "surfels_middle", "surfels_coarse"};
    for (int level = 0; level < mapping::kSurfelLayers; ++level) {
      const mapping::SurfelLayer& layer = locator_->registration().layer(level);
      builder.pool(kLayers[level], [&layer] {
        return PoolLevel{layer.keys().size(), layer.size(), layer.counts().pool_full};
      });
    }
  }

  void take(rt::JobContext& context, std::uint32_t index) {
    rt::ScanHeader header = (*sweeps_)[index].header;
    const bool posed = (header.flags & rt::kScanPosed) != 0;
    const mapping::StraightSweep& placed = sweeps_->place(index);
    const bool known = placed.status == Status::ok && (!posed || config_.scan_poses);
    if (!known && !posed && sweeps_->has_odometry()) {
      ++unplaced_;
      return;
    }
    if (!posed) header.stamp_ns += sweeps_->config().time_offset_ns;
    rt::PointScan scan = placed.scan;
    scan.header.stamp_ns = header.stamp_ns;
    const mapping::OdometryHint hint = hint_of(placed, known);
    if (config_.start_on_map && locator_->is_unplaced() && hint.known) start_on_map(hint);
    const mapping::Located& located = locator_->locate(scan, hint);
    ++access_.scans;
    access_.hint = hint;
    access_.has_odometry = known;
    access_.q_level_sensor = hint.T_odom_sensor.q;
    if (mapping::is_placed(located.verdict)) T_odom_last_ = placed.pose;
    context.add_units(located.steps);
    put(located);
    rt::LocatedPose* const report = poses_->claim();
    if (report == nullptr) return;  // what nobody took is counted; each tells of its own scan alone
    *report = output_;
    poses_->publish();
  }

  /// Map and odometry are one, as far as a lost robot is looked for. A scan decides.
  void start_on_map(const mapping::OdometryHint& hint) {
    const mapping::RegistrationConfig& config = locator_->registration().config();
    const double move_m = std::max(config.recovery_move_m, 0.1);
    const double turn_rad = std::max(config.recovery_turn_rad, 0.05);
    double covariance[36]{};
    for (int i = 0; i < 3; ++i) {
      covariance[7 * i] = move_m * move_m;
      covariance[7 * (i + 3)] = turn_rad * turn_rad;
    }
    static_cast<void>(locator_->place(hint.T_odom_sensor, covariance, hint));  // refused: it stays unplaced
  }

  /// The first scan of a robot without odometry is taken where the robot starts: the map's frame is then the
  /// world's, as the start has it.
  mapping::OdometryHint hint_of(const mapping::StraightSweep& placed, bool known) const {
    mapping::OdometryHint hint;
    const bool begins = !locator_->has_begun();
    hint.known = known || begins;
    hint.T_odom_sensor = known ? placed.pose : T_start_sensor_;
    const RigidPose moved = after(inverse(begins ? hint.T_odom_sensor : T_odom_last_), hint.T_odom_sensor);
    hint.sigma_move_m = config_.sigma_move_m + config_.sigma_per_way * rt::norm(moved.p);
    hint.sigma_turn_rad =
        config_.sigma_turn_rad + config_.sigma_per_turn * rt::norm(rt::log_rotation(moved.q));
    return hint;
  }

  void put(const mapping::Located& located) {
    output_.stamp_ns = located.stamp_ns;
    output_.verdict = static_cast<std::uint8_t>(located.verdict);
    rt::store(located.T_map_odom.p, output_.p_map_odom_m);
    rt::store(located.T_map_odom.q, output_.q_map_odom);
    rt::store(located.T_map_sensor.p, output_.p_map_sensor_m);
    rt::store(located.T_map_sensor.q, output_.q_map_sensor);
    const RigidPose body = after(located.T_map_sensor, inverse(T_body_sensor_));
    rt::store(body.p, output_.p_map_body_m);
    rt::store(body.q, output_.q_map_body);
    for (int i = 0; i < 36; ++i) output_.covariance[i] = located.covariance[i];
    output_.share = located.share;
    output_.known = located.known;
    output_.crossed = located.crossed;
    output_.returns = located.returns;
    output_.steps = located.steps;
    output_.weak_moves = located.weak_moves;
    output_.weak_turns = located.weak_turns;
    for (int i = 0; i < 3; ++i) {
      const mapping::WeakDirection& move = located.weak_move[i];
      const mapping::WeakDirection& turn = located.weak_turn[i];
      for (int k = 0; k < 3; ++k) {
        output_.weak_move_map[3 * i + k] = move.axis_map[k];
        output_.weak_turn_map[3 * i + k] = turn.axis_map[k];
      }
      output_.weak_move_sigma_m[i] = move.sigma;
      output_.weak_turn_sigma_rad[i] = turn.sigma;
    }
    output_.scans = located.counts.in;
    output_.placed = located.counts.first + located.counts.accepted + located.counts.new_place;
  }

  LocateConfig config_;
  LidarSweeps* sweeps_{};
  std::unique_ptr<LidarSweeps> own_;  // null where the map has them
  std::unique_ptr<mapping::Locator> locator_;
  LocateAccess access_;  // of this job, for who comes behind in the table
  std::unique_ptr<ReportQueue<rt::LocatedPose>> poses_;
  const rt::Task<rt::LocatedPose>* task_{};
  RigidPose T_body_sensor_;
  RigidPose T_start_sensor_;
  RigidPose T_odom_last_;  // T_odom_sensor of the scan that was placed last
  std::uint64_t unplaced_{};
  rt::LocatedPose output_;
};

}  // namespace

std::unique_ptr<Part> make_locate(VehicleBuilder& builder) { return std::make_unique<LocatePart>(builder); }

}  // namespace sortie::firmware
