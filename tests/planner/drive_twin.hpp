// SPDX-License-Identifier: BSD-3-Clause
// A robot to drive against: belts with a lag, slip, turning centres that are not where the drive thinks.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "planner/ugv_drive.hpp"
#include "rt/rotation.hpp"

namespace sortie::planner::test {

inline constexpr rt::Nanoseconds kStep_ns = 5 * rt::kNanosecondsPerMillisecond;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Uniform numbers from the generator's bits.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  bool one_in(std::uint64_t n) { return random_() % n == 0; }

 private:
  std::mt19937_64 random_;
};

/// A unicycle on belts, on exact arcs.
struct Robot {
  double x{}, y{}, heading{}, roll{}, pitch{};
  double left{}, right{};  // belts
  double lag_s{0.05};
  double grip{1.0};        // share of the belts' travel that moves the body
  double turn_share{1.0};  // share of the turn that the drive expects
  bool held{};             // something is in the way forward
  double width_m{0.4};

  void drive(const rt::DriveCommand& command, double dt_s) {
    const bool on = (command.flags & kDriveEnabled) != 0;
    const double follow = 1.0 - std::exp(-dt_s / lag_s);
    left += follow * ((on ? command.left_m_s : 0.0) - left);
    right += follow * ((on ? command.right_m_s : 0.0) - right);
    const double v = grip * 0.5 * (left + right);
    const double w = turn_share * (right - left) / width_m;
    if (held && v > 0.0) return;
    const double half = 0.5 * w * dt_s;
    const double chord = v * dt_s * (std::fabs(half) < 1e-9 ? 1.0 : std::sin(half) / half);
    x += chord * std::cos(heading + half);
    y += chord * std::sin(heading + half);
    heading += w * dt_s;
  }
  rt::PoseEstimate pose(rt::Nanoseconds stamp_ns) const {
    rt::PoseEstimate pose;
    pose.stamp_ns = stamp_ns;
    pose.p_world_body_m[0] = x;
    pose.p_world_body_m[1] = y;
    rt::store(rt::from_yaw_pitch_roll(heading, pitch, roll), pose.q_world_body);
    pose.flags = 1;
    return pose;
  }
};

inline UgvDriveConfig usual() {
  UgvDriveConfig config;
  config.step_ns = kStep_ns;
  config.icr = IcrModel::from_efficiency(0.4, 1.0);
  config.postures = 4;
  config.guard.resume_ns = 100 * rt::kNanosecondsPerMillisecond;
  return config;
}

/// Drive and robot together. Every step is checked: limits of body and belts, ramps that fit to what is
/// going on, finite outputs.
struct Bench {
  explicit Bench(const UgvDriveConfig& setup = usual()) : config(setup), drive(setup) {
    robot.width_m = setup.icr.y_left_m - setup.icr.y_right_m;
  }
  /// One step with a pose; gives the drive's status.
  Status step_with(const rt::PoseEstimate& pose, const UgvDriveInputs& inputs = {}) {
    const UgvDriveOutput before = drive.output();
    const Status status = drive.update(pose, inputs, now_ns);
    const UgvDriveOutput& out = drive.output();
    const double dt = rt::to_seconds(kStep_ns);
    const double most = std::max(config.ramps.speed.acceleration, config.stop.acceleration);
    const double firmer = config.stop.acceleration / config.ramps.speed.acceleration;
    good =
        good && std::isfinite(out.left_m_s) && std::isfinite(out.right_m_s) &&
        std::fabs(out.left_m_s) <= config.max_track_m_s + 1e-8 &&
        std::fabs(out.right_m_s) <= config.max_track_m_s + 1e-8 &&
        std::fabs(out.speed_m_s) <= config.max_speed_m_s + 1e-9 &&
        std::fabs(out.turn_rad_s) <= config.max_turn_rad_s + 1e-9 &&
        std::fabs(out.speed_m_s - before.speed_m_s) <= most * dt + 1e-9 &&
        std::fabs(out.turn_rad_s - before.turn_rad_s) <= firmer * config.ramps.turn.acceleration * dt + 1e-9;
    robot.drive(drive.output(), dt);
    return status;
  }
  /// So many seconds with what the robot really does.
  void run(double seconds, const UgvDriveInputs& inputs = {}) {
    for (int i = 0; i < std::lround(seconds / rt::to_seconds(kStep_ns)); ++i) {
      now_ns += kStep_ns;
      REQUIRE(step_with(robot.pose(now_ns), inputs) == Status::ok);
    }
    REQUIRE(good);
  }
  /// The same with a request every 50 ms.
  void ask(double seconds, rt::DriveRequest request) {
    for (int i = 0; i < std::lround(seconds / 0.05); ++i) {
      request.counter = drive.output().request_counter + 1;
      request.stamp_ns = now_ns;
      REQUIRE(drive.request(request, now_ns) == Status::ok);
      run(0.05);
    }
  }
  bool stands() const { return drive.output().left_m_s == 0.0 && drive.output().right_m_s == 0.0; }
  std::uint32_t stop() const { return drive.output().stop; }
  bool has(DriveFlags flag) const { return (drive.output().flags & flag) != 0; }
  DriveSource source() const { return static_cast<DriveSource>(drive.output().source); }

  UgvDriveConfig config;
  UgvDrive drive;
  Robot robot;
  rt::Nanoseconds now_ns{};
  bool good{true};
};

/// A bench on its way along a long route, at full speed.
inline Bench on_the_road(const UgvDriveConfig& config = usual()) {
  Bench bench(config);
  const Waypoint far[] = {{1000, 0}};
  REQUIRE(bench.drive.set_route(far) == Status::ok);
  bench.run(3.0);
  REQUIRE(bench.drive.output().speed_m_s == Approx(config.max_speed_m_s));
  return bench;
}

inline rt::DriveRequest request_of(double speed_m_s, double turn_rad_s = 0.0,
                                   rt::DriveMode mode = rt::DriveMode::drive) {
  rt::DriveRequest request;
  request.speed_m_s = speed_m_s;
  request.turn_rad_s = turn_rad_s;
  request.mode = static_cast<std::uint32_t>(mode);
  return request;
}

}  // namespace sortie::planner::test
