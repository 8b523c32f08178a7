// SPDX-License-Identifier: BSD-3-Clause
// A whole ground robot, its drives' power and its emergency stop, on each protocol: what stopped it does not
// start it again. It moves when it is asked anew, and not before.
#include <cmath>

#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::testing;

namespace {

using rt::DriveMode;

/// A request of somebody outside, at a time of the run.
struct Ask {
  double at_s;
  DriveMode mode;
  double speed_m_s = 0.0;
  std::uint32_t flags = 0;
};

// The simulated robot as it is, with somebody beside it who asks for things.
class BenchWithAsker final : public firmware::SimulatedRobot {
 public:
  BenchWithAsker(std::unique_ptr<firmware::SimulatedRobot> robot, firmware::Vehicle*& vehicle,
                 std::vector<Ask> asks, std::vector<double>& angles)
      : robot_(std::move(robot)), vehicle_(vehicle), asks_(std::move(asks)), angles_(angles) {}
  void step(rt::Nanoseconds now_ns) override {
    robot_->step(now_ns);
    const std::optional<firmware::MotorsNews> news = vehicle_->motors_news();
    if (news && news->emergency) ++pressed_ms;
    rt::ContactTruth truth;
    while (robot_->contacts(truth) && now_ns >= static_cast<rt::Nanoseconds>(angles_.size()) * 1'000'000)
      angles_.push_back(truth.flipper_angle_rad[0]);
    for (; next_ < asks_.size() && now_ns >= static_cast<rt::Nanoseconds>(1e9 * asks_[next_].at_s); ++next_) {
      rt::DriveRequest request;
      request.stamp_ns = now_ns;
      request.counter = static_cast<std::int64_t>(next_) + 1;
      request.mode = static_cast<std::uint32_t>(asks_[next_].mode);
      request.speed_m_s = asks_[next_].speed_m_s;
      request.flags = asks_[next_].flags;
      REQUIRE(vehicle_->drive_requests().port->push(request, now_ns) == Status::ok);
    }
  }
  rt::TruthSample truth() const override { return robot_->truth(); }
  bool contacts(rt::ContactTruth& truth) const override { return robot_->contacts(truth); }
  bool sensors(rt::SensorTruth& truth) const override { return robot_->sensors(truth); }
  drivers::CanBus* vehicle_can() override { return robot_->vehicle_can(); }
  drivers::SslPort* vehicle_ssl() override { return robot_->vehicle_ssl(); }
  /// How long the vehicle itself said that an emergency stop is pressed, in the newest run.
  inline static int pressed_ms = 0;

 private:
  std::unique_ptr<firmware::SimulatedRobot> robot_;
  firmware::Vehicle*& vehicle_;
  std::vector<Ask> asks_;
  std::vector<double>& angles_;
  std::size_t next_{};
};

/// The robot on the flat behind the pallet, driving on from 0.5 s by its mission.
class Run {
 public:
  Run(const std::string& protocol, const std::string& stops, std::vector<Ask> asks, double seconds,
      const std::string& mission = "[{at_s=0.5,speed_m_s=-0.1},{at_s=1000.0}]") {
    firmware::Vehicle* vehicle = nullptr;
    BenchWithAsker::pressed_ms = 0;
    firmware::VehicleRegistry vehicles;
    for (const auto& [name, make] : firmware::own_vehicles())
      vehicles.emplace_back(name, [&vehicle, make = make](firmware::VehicleBuilder& builder) {
        auto made = make(builder);
        vehicle = made.get();
        return made;
      });
    firmware::LiveRunOptions options;
    options.scene = "ugv_pallet";
    options.overrides = {"hil.lidar_rows=4",
                         "hil.lidar_columns=64",
                         "limits.voxels=32768",
                         "drives.protocol=" + protocol,
                         "mission.commands=" + mission,
                         "hil.stops=" + stops,
                         "drive.remote=true"};
    options.seconds = seconds;
    options.virtual_time = true;
    options.lcm_url = "none";
    outcome_ = firmware::run_live(
        vehicles,
        [&](firmware::Profile& profile, drivers::ScanSink* scans) {
          return std::make_unique<BenchWithAsker>(toolchain::make_simulated_robot(profile, scans), vehicle,
                                                  asks, angles_);
        },
        options);
  }
  /// Way between two times, m.
  double way(double from_s, double to_s) const {
    const firmware::TimedPose& from = at(from_s);
    const firmware::TimedPose& to = at(to_s);
    return std::hypot(to.p[0] - from.p[0], to.p[1] - from.p[1]);
  }
  /// How far the front left flipper has turned between two times, rad.
  double turn(double from_s, double to_s) const {
    return std::fabs(angles_.at(static_cast<std::size_t>(1e3 * to_s)) -
                     angles_.at(static_cast<std::size_t>(1e3 * from_s)));
  }
  std::uint64_t counter(const char* name) const { return outcome_.results.counters.at(name); }

 private:
  const firmware::TimedPose& at(double s) const {
    std::size_t i = 0;
    while (i + 1 < outcome_.truth.size() && 1e-9 * static_cast<double>(outcome_.truth[i].stamp_ns) < s) ++i;
    return outcome_.truth[i];
  }
  firmware::LiveRunOutcome outcome_;
  std::vector<double> angles_;  // one a millisecond
};

constexpr double kStill_m = 0.01;  // what suspension and brakes give

}  // namespace

TEST_CASE(
    "A robot whose emergency stop was released, or whose drives have power again, stands until it is asked "
    "anew",
    "[heavy]") {
  const std::string protocol = GENERATE("own", "canopen", "odrive");
  const bool press = GENERATE(true, false);
  const std::string stops = press ? "[{at_s=4.0,what=\"press\"},{at_s=5.5,what=\"release\"}]"
                                  : "[{at_s=4.0,what=\"power_off\"},{at_s=5.5,what=\"power_on\"}]";
  CAPTURE(protocol, stops);
  SECTION("a release asks, and the mission goes on") {
    const Run run(protocol, stops, {{11.0, DriveMode::release}}, 14.0);
    CHECK(run.way(2.5, 4.0) > 0.05);
    CHECK(run.way(5.0, 11.0) < kStill_m);
    CHECK(run.way(12.0, 14.0) > 0.05);
  }
  SECTION("so does the request that takes control") {
    const Run run(protocol, stops,
                  {{11.0, DriveMode::drive, 0.1},
                   {11.25, DriveMode::drive, 0.1},
                   {11.5, DriveMode::drive, 0.1},
                   {11.75, DriveMode::drive, 0.1},
                   {12.0, DriveMode::drive, 0.1}},
                  12.2);
    CHECK(run.way(5.0, 11.0) < kStill_m);
    CHECK(run.way(11.0, 12.2) > 0.02);
  }
  SECTION("a stream that goes on in the background does not, until it says that it is anew") {
    std::vector<Ask> asks;
    for (double at_s = 2.0; at_s < 11.9; at_s += 0.2)
      asks.push_back({at_s, DriveMode::drive, -0.1, at_s > 10.0 ? std::uint32_t{rt::kDriveAnew} : 0u});
    const Run run(protocol, stops, asks, 12.0);
    CHECK(run.way(3.0, 4.0) > 0.05);
    CHECK(run.way(5.0, 10.0) < kStill_m);
    CHECK(run.way(10.5, 12.0) > 0.05);
  }
  SECTION("what is asked before the end does not count") {
    const Run run(protocol, stops, {{5.0, DriveMode::halt}, {5.2, DriveMode::release}}, 11.0);
    if (press || protocol == "own") CHECK(run.way(5.0, 11.0) < kStill_m);
    // Who asks drives that are without power asks those that are being set up: for five seconds that waits.
    if (!press && protocol != "own") CHECK(run.way(5.0, 11.0) > 0.05);
  }
}

TEST_CASE("An emergency stop by request ends by emergency_end and a release") {
  const std::string protocol = GENERATE("own", "canopen", "odrive");
  CAPTURE(protocol);
  const Run run(protocol, "[]",
                {{4.0, DriveMode::emergency},
                 {5.0, DriveMode::release},
                 {5.5, DriveMode::drive, 0.1},
                 {6.0, DriveMode::emergency_end},
                 {6.5, DriveMode::drive, 0.1},
                 {9.0, DriveMode::release}},
                12.0);
  CHECK(run.way(2.5, 4.0) > 0.05);
  CHECK(run.way(5.0, 9.0) < kStill_m);
  CHECK(run.way(10.0, 12.0) > 0.05);
  CHECK(run.counter("emergency_stops") == 1);
  CHECK(run.counter("drive_stops_emergency") == 1);
  CHECK(BenchWithAsker::pressed_ms == Approx(2000).margin(30));  // 4 s to 6 s
}

TEST_CASE("Flippers stand too until they are asked anew") {
  const std::string protocol = GENERATE("own", "canopen", "odrive");
  CAPTURE(protocol);
  // The mission changes their posture while they are stopped, and after that.
  const Run run(protocol, "[{at_s=4.0,what=\"press\"},{at_s=5.5,what=\"release\"}]",
                {{11.0, DriveMode::release}}, 14.0,
                "[{at_s=0.5,posture=\"climb\"},{at_s=2.0,posture=\"flat\"},{at_s=6.0,posture=\"climb\"},{at_"
                "s=1000.0}]");
  CHECK(run.turn(1.9, 3.9) > 0.5);
  CHECK(run.turn(5.0, 11.0) < 0.03);
  CHECK(run.turn(11.0, 13.5) > 0.5);
}

TEST_CASE("A line of the emergency stop that cannot be read is refused with its cure") {
  firmware::LiveRunOptions options;
  options.scene = "ugv_pallet";
  options.lcm_url = "none";
  const auto refused = [&](std::vector<std::string> overrides) {
    options.overrides = std::move(overrides);
    return message_of<firmware::ProfileError>([&] {
      static_cast<void>(
          firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options));
    });
  };
  // A line without its chip would be a stop that does not stop.
  CHECK_THAT(refused({"emergency.gpio_line=3"}), Catch::Contains("emergency.gpio_chip"));
  CHECK_THAT(refused({"emergency.gpio_active_low=false"}), Catch::Contains("emergency.gpio_chip"));
  // On a robot it is opened before anything moves.
  options.can_interface = "nocan9";
  CHECK_THAT(refused({"emergency.gpio_chip=/dev/none"}),
             Catch::Contains("/dev/none") && Catch::Contains("gpiodetect"));
}
