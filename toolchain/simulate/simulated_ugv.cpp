// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/simulated_ugv.hpp"

#include <algorithm>

#include "drivers/can_stub.hpp"
#include "drivers/ssl_port.hpp"
#include "firmware_like/parts/ugv_motors.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/units.hpp"
#include "hil/ugv_plant.hpp"
#include "toolchain/simulate/hil_config.hpp"

namespace sortie::toolchain {

namespace {

// The simulated drives are what the runtime expects on the bus.
void read_drives(firmware::Profile& profile, hil::UgvConfig& config) {
  const firmware::MotorsConfig motors = firmware::read_motors(profile, config.contacts);
  if (const auto& drives = motors.canopen) {
    config.drives.enabled = true;
    config.drives.track_nodes = drives->track_nodes;
    config.drives.flipper_nodes = drives->flipper_nodes;
    config.drives.increments_per_m = drives->increments_per_m;
    config.drives.increments_per_rad = drives->increments_per_rad;
    config.drives.rated_torque_n_m = drives->rated_torque_n_m;
  }
  if (const auto& axes = motors.odrive) {
    config.axes.enabled = true;
    config.axes.track_nodes = axes->track_nodes;
    config.axes.flipper_nodes = axes->flipper_nodes;
    config.axes.turns_per_m = axes->turns_per_m;
    config.axes.turns_per_rad = axes->turns_per_rad;
    config.axes.torque_per_a_n_m = axes->torque_per_a_n_m;
    config.axes.watchdog_ns = firmware::milliseconds(
        profile.number("hil.axis_watchdog_ms", {firmware::in_ms(config.axes.watchdog_ns), 0, 10'000, "ms",
                                                "of the simulated ODrives; 0: somebody forgot to set it"}));
  }
}

std::vector<hil::StopDeed> read_stops(firmware::Profile& profile) {
  using Kind = firmware::ColumnSpec::Kind;
  using What = hil::StopDeed::What;
  constexpr const char* kNames[] = {"press", "release", "power_off", "power_on"};
  const std::vector<firmware::ColumnSpec> columns = {{"at_s", Kind::number, {0, 0, 1e7, "s"}, true},
                                                     {"what", Kind::text, {}, true}};
  std::vector<hil::StopDeed> deeds;
  for (const firmware::ProfileRow& row :
       profile.rows("hil.stops", columns, 64,
                    "what: press or release the emergency stop's button on the bus, "
                    "power_off or power_on of all drives")) {
    const rt::Nanoseconds at_ns = firmware::milliseconds(1e3 * row.numbers.at("at_s"));
    if (!deeds.empty() && at_ns <= deeds.back().at_ns)
      profile.fail(row.path, "at_s must rise from row to row");
    const auto found = std::find(std::begin(kNames), std::end(kNames), row.texts.at("what"));
    if (found == std::end(kNames)) profile.fail(row.path, "what is press, release, power_off or power_on");
    deeds.push_back({at_ns, static_cast<What>(found - std::begin(kNames))});
  }
  return deeds;
}

// Where the robot stands in the hall, and the way that the mission drives there. The mission is in the
// odometry's world, in which the robot stands at [initial].
void read_start(firmware::Profile& profile, hil::UgvConfig& config) {
  hil::RobotConfig& robot = config.robot;
  const char* const where = "where it stands at the start";
  read_number(profile, "hil.start_x_m", robot.start_x_m, -1000, 1000, "m", where);
  read_number(profile, "hil.start_y_m", robot.start_y_m, -1000, 1000, "m", where);
  robot.start_yaw_rad =
      profile.number("hil.start_yaw_deg", {0, -360, 360, "deg", "heading at the start"}) * firmware::kDegree;
  const firmware::InitialPose initial = firmware::read_initial(profile);
  const rt::Quaternion q_odom_body = rt::to_quaternion(initial.q_world_body);
  const rt::SinCos turn = rt::sincos(robot.start_yaw_rad);
  const auto route =
      profile.points("mission.waypoints", hil::HallConfig::kMaxPath - 1, "way to drive, in order");
  hil::PlanPoint* const path = config.hall.path_m;
  for (std::size_t i = 0; i < route.size(); ++i) {
    const rt::Vector3 ahead = rt::rotate_back(
        q_odom_body, {route[i][0] - initial.p_world_body_m[0], route[i][1] - initial.p_world_body_m[1], 0});
    path[i + 1] = {robot.start_x_m + turn.cos * ahead.x - turn.sin * ahead.y,
                   robot.start_y_m + turn.sin * ahead.x + turn.cos * ahead.y};
  }
  if (!route.empty()) config.hall.path_points = static_cast<std::uint32_t>(route.size() + 1);
  path[0] = {robot.start_x_m, robot.start_y_m};
}

hil::UgvConfig read_config(firmware::Profile& profile) {
  hil::UgvConfig config;
  const auto number = [&profile](auto&&... key) { read_number(profile, key...); };
  config.seed = static_cast<std::uint64_t>(
      profile.integer("hil.seed", {1, 0, 1e15, "", "of all sensor noise and faults"}));
  config.hall.seed =
      static_cast<std::uint64_t>(profile.integer("hil.hall_seed", {1, 0, 1e15, "", "of the furniture"}));
  number("hil.furniture", config.hall.furniture, 0, 200, "", "pieces that are tried");
  number("hil.ramp_height_m", config.hall.ramp_height_m, 0, 1, "m", "of the ramp across the way; 0: none");
  number("hil.steering_efficiency", config.robot.steering_efficiency, 0.1, 1, "",
         "track distance / distance of the turning centres");
  number("hil.slip_left", config.robot.slip_left, 0, 0.9, "", "share of the left belt's travel that is lost");
  number("hil.slip_right", config.robot.slip_right, 0, 0.9, "",
         "share of the right belt's travel that is lost");
  read_range_sensors(profile, config);
  read_start(profile, config);  // furniture keeps off the way
  config.command_faults.drop =
      profile.number("hil.command_loss", {0, 0, 1, "", "share of drive commands that are not heard"});
  read_inertial(profile, config);
  read_course(profile, config);
  read_drives(profile, config);
  config.stops = read_stops(profile);
  return config;
}

// Plant and runtime are two nodes of one bus; the bus belongs to the plant's thread.
class SimulatedUgv final : public firmware::SimulatedRobot {
 public:
  SimulatedUgv(const hil::UgvConfig& config, drivers::ScanSink* scans, rt::Nanoseconds contacts_every_ns)
      : vehicle_(bus_.attach("runtime")),
        plant_port_(bus_.attach("plant")),
        plant_(config, plant_port_, scans, &ssl_link_),
        has_ssl_(config.ssl.enabled),
        seed_(config.seed),
        course_seed_(config.course.seed),
        contacts_every_ns_(contacts_every_ns) {}

  void step(rt::Nanoseconds now_ns) override {
    bus_.advance(now_ns);
    static_cast<void>(
        plant_.step(now_ns));  // less than a step since the last: nothing to do; late steps are counted
    bus_.advance(now_ns);
  }
  rt::TruthSample truth() const override { return plant_.truth(); }
  bool contacts(rt::ContactTruth& truth) const override { return plant_.contact_truth(truth); }
  bool sensors(rt::SensorTruth& truth) const override {
    truth = plant_.sensor_truth();
    return truth.stamp_ns != 0;
  }
  rt::Nanoseconds contacts_every_ns() const override { return contacts_every_ns_; }
  void set_device_clock(rt::Nanoseconds reading_ns) override { plant_.set_device_clock(reading_ns); }
  drivers::CanBus* vehicle_can() override { return &vehicle_; }
  drivers::SslPort* vehicle_ssl() override { return has_ssl_ ? &ssl_link_ : nullptr; }
  std::string describe() const override {
    const std::string what = "simulated ugv, seed " + std::to_string(seed_);
    if (tracked() == nullptr)
      return what + ", in a hall, furniture seed " + std::to_string(plant_.hall().seed);
    return what + ", with contacts, on a course of " + std::to_string(plant_.world().size()) +
           " solids, seed " + std::to_string(course_seed_);
  }
  void add_counters(std::map<std::string, std::uint64_t>& counters) const override {
    counters["bench_frames_sent"] = plant_.counters().frames_sent;
    counters["bench_frames_refused"] = plant_.counters().frames_refused;
    counters["bench_commands"] = plant_.counters().commands_taken;
    counters["bench_drive_stale_ms"] = plant_.robot_counters().stale_steps;
    counters["bench_late_steps"] = plant_.counters().late_steps;
    counters["bench_can_frames"] = bus_.stats().frames;
    if (plant_.drives().size() != 0) {
      std::uint64_t& lost = counters["bench_heartbeats_lost"];
      for (std::size_t i = 0; i < plant_.drives().size(); ++i)
        lost += plant_.drives().node(i).counters().heartbeat_lost;
    }
    if (plant_.axes().size() != 0) {
      std::uint64_t& stopped = counters["bench_watchdogs"];
      for (std::size_t i = 0; i < plant_.axes().size(); ++i)
        stopped += plant_.axes().node(i).counters().watchdog;
    }
    add_range_counters(plant_, counters);
    if (tracked() == nullptr) return;
    const hil::PlantCounters& contacts = tracked()->plant().counters();
    counters["bench_flipper_commands"] = plant_.counters().flipper_commands;
    counters["bench_not_converged"] = contacts.not_converged;
    counters["bench_rejected_steps"] = contacts.rejected;
    counters["bench_penetration_um"] = static_cast<std::uint64_t>(1e6 * contacts.penetration_m);
  }

 private:
  // The body with contacts, or null.
  const hil::TrackedBody* tracked() const { return dynamic_cast<const hil::TrackedBody*>(&plant_.body()); }

  drivers::CanStub bus_;
  drivers::SslStub ssl_link_;
  drivers::CanBus& vehicle_;
  drivers::CanBus& plant_port_;
  hil::UgvPlant plant_;
  bool has_ssl_;
  std::uint64_t seed_;
  std::uint64_t course_seed_;
  rt::Nanoseconds contacts_every_ns_;
};

// Period of the contacts' truth; 0: none. The default is the rate of the pose's.
rt::Nanoseconds read_contacts_period(firmware::Profile& profile, const hil::UgvConfig& config) {
  if (!config.contacts) return 0;
  const auto rate = static_cast<rt::Nanoseconds>(profile.integer(
      "hil.contact_truth_hz",
      {100, 0, 1000, "Hz", "how often contacts are written to the log; 0: not, must divide 1000"}));
  if (rate != 0 && 1000 % rate != 0) profile.fail("hil.contact_truth_hz", "must divide 1000");
  return rate == 0 ? 0 : rt::kNanosecondsPerSecond / rate;
}

}  // namespace

std::unique_ptr<firmware::SimulatedRobot> make_simulated_robot(firmware::Profile& profile,
                                                               drivers::ScanSink* scans) {
  if (!profile.has("hil")) return nullptr;
  if (profile.vehicle() == "uav") return make_simulated_uav(profile, scans);
  if (profile.vehicle() != "ugv") return nullptr;
  const hil::UgvConfig config = read_config(profile);
  const rt::Nanoseconds contacts_every_ns = read_contacts_period(profile, config);
  try {
    return std::make_unique<SimulatedUgv>(config, scans, contacts_every_ns);
  } catch (const std::runtime_error& error) {
    profile.fail("hil", error.what());
  }
}

}  // namespace sortie::toolchain
