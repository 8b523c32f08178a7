// SPDX-License-Identifier: BSD-3-Clause
// The plant driven over a course with the policy in the loop, or with a fixed posture: what both are judged
// by.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include "hil/plant/course.hpp"
#include "hil/plant/obstacles.hpp"
#include "hil/plant/tracked_plant.hpp"
#include "tests/planner/flipper_rig.hpp"

namespace sortie::planner {

/// A scene along x, driven from 0 to `goal_m`, and its true heights as cells.
struct DrivenCourse {
  const char* name;
  double goal_m{};
  bool may_stall{};  ///< the policy is known not to arrive
  std::unique_ptr<hil::PlantScene> scene = std::make_unique<hil::PlantScene>();
  CellGround ground;

  DrivenCourse(const char* called, double goal, const std::function<void(hil::PlantScene&)>& build)
      : name(called), goal_m(goal) {
    const auto world = std::make_unique<hil::World>();
    (void)scene->add_half_space({0, 0, 1}, {0, 0, 0});
    build(*scene);
    if (hil::add_to_world(*scene, *world) != Status::ok || world->finalize() != Status::ok) return;
    ground = CellGround::of(
        [&world](double x, double y) {
          return 5.0 - world->cast({x, y, 5.0}, {0, 0, -1}, 10.0).range_m;
        },
        110);
  }
};

/// The obstacles of the mission's scenes, one after another: what stands in each.
inline std::vector<DrivenCourse> driven_courses() {
  std::vector<DrivenCourse> courses;
  courses.emplace_back("step up and down, 15 cm", 4.2, [](hil::PlantScene& s) {
    (void)s.add_box({1.9, 0, 0.075}, {}, {0.9, 1.0, 0.075});
  });
  courses.emplace_back("pallet", 3.2, [](hil::PlantScene& s) { (void)hil::add_pallet(s, {{1.0, 0, 0}, 0}); });
  courses.emplace_back("four stairs of 17 x 28 cm up", 3.0, [](hil::PlantScene& s) {
    (void)hil::add_stairs(s, {{1.0, 0, 0}, 0}, {4, 0.28, 0.17, 1.6, 2.0});
  });
  courses.back().may_stall = true;
  courses.emplace_back("four stairs of 17 x 28 cm down", 4.6, [](hil::PlantScene& s) {
    // From the landing, which begins at 3.14 m, down again.
    (void)hil::add_stairs(s, {{3.14, 0, 0}, 3.14159265358979}, {4, 0.28, 0.17, 1.6, 3.2});
  });
  return courses;
}

/// How a drive went.
struct DriveResult {
  bool arrived{}, tipped{};
  double seconds{};
  double x_m{};
  double peak_pitch_rad_s{};  ///< over 20 ms
  double belly_s{};           ///< time in which the body touches
  int jobs{}, stops{}, slows{};
  FlipperVerdict last{};
  FlipperReason reason{};
  double units{};  ///< mean a job

  std::string words(const char* what) const {
    char line[256];
    std::snprintf(
        line, sizeof line,
        "%-34s %s%s x %.2f m, %5.1f s, peak pitch rate %.2f rad/s, belly %.1f s, %d of %d jobs slow, "
        "%d still (last: %s), %.0f units a job",
        what, arrived ? "arrived" : "NOT THERE", tipped ? ", TIPPED" : "", x_m, seconds, peak_pitch_rad_s,
        belly_s, slows, jobs, stops, to_string(reason), units);
    return line;
  }
};

/// Drives at 0.2 m/s, at most 60 s. Without a policy the flippers stay at `fixed`, and so is it where the
/// policy leaves it to the mission. `view`: what the policy sees.
inline DriveResult drive(const DrivenCourse& course, const HeightView& view, FlipperPolicy* policy,
                         const FlipperSet& fixed, double friction) {
  constexpr double kDriveStep_s = 2e-3;
  constexpr double kSpeed_m_s = 0.2;
  hil::PlantConfig config;
  config.vehicle.friction = friction;
  const HeightCell under = CellGround::cell(&course.ground, 0, 0);
  config.start_m = {0, 0, under.high_m + 0.08};
  hil::PlantCommand command;
  for (int f = 0; f < 4; ++f) command.flipper_rad[f] = config.start_flipper_rad[f] = fixed.angle_rad[f];
  const auto plant = std::make_unique<hil::TrackedPlant>(config, *course.scene);
  DriveResult result;
  FlipperDecision decision;
  double share = policy != nullptr ? 0.0 : 1.0, speed = 0.0, turn = 0.0, pitch_before = 0.0;
  for (int step = 0; step < 30000; ++step) {
    const hil::Quat& q = plant->state().q_world_body;
    const rt::Quaternion turned{q.w, q.x, q.y, q.z};
    const hil::Vec3 p = plant->p_world_body_m();
    const double pitch = rt::pitch_of(turned), roll = rt::roll_of(turned), yaw = rt::yaw_of(turned);
    result.seconds = step * kDriveStep_s;
    result.x_m = p.x;
    if (step % 10 == 0) {
      if (step > 250)
        result.peak_pitch_rad_s =
            std::max(result.peak_pitch_rad_s, std::fabs(pitch - pitch_before) / (10 * kDriveStep_s));
      pitch_before = pitch;
    }
    for (const hil::ContactTag& tag : plant->tags())
      if (tag.part == static_cast<std::uint8_t>(rt::VehiclePart::body)) {
        result.belly_s += kDriveStep_s;
        break;
      }
    result.tipped = std::max(std::fabs(pitch), std::fabs(roll)) > 1.0;
    result.arrived = p.x > course.goal_m;
    if (result.tipped || result.arrived) break;
    if (step >= 250 && step % 25 == 0) {  // 20 Hz, after half a second of coming to rest
      turn = std::clamp(-1.0 * yaw - 1.0 * p.y, -0.3, 0.3);
      if (policy != nullptr) {
        FlipperInput in = flipper_input(step * static_cast<rt::Nanoseconds>(2'000'000), {p.x, p.y, yaw}, p.z);
        in.pitch_rad = pitch;
        in.roll_rad = roll;
        in.arc = {kSpeed_m_s, turn};
        for (int f = 0; f < 4; ++f) {
          in.measured_rad[f] = plant->state().flipper_rad[f];
          in.mission_rad[f] = fixed.angle_rad[f];
        }
        if (policy->decide(view, in, decision) != Status::ok) break;
        share = decision.share;
        ++result.jobs;
        result.units += decision.units;
        if (share == 0.0) ++result.stops;
        if (decision.verdict == FlipperVerdict::slow) ++result.slows;
        for (int f = 0; f < 4; ++f) command.flipper_rad[f] = decision.angle_rad[f];
        result.last = decision.verdict;
        if (decision.reason != FlipperReason::none) result.reason = decision.reason;
        if (decision.verdict == FlipperVerdict::stop && decision.reason != FlipperReason::flippers_late)
          break;
      }
    }
    if (step >= 250) speed += std::clamp(share * kSpeed_m_s - speed, -1e-3, 1e-3);  // 0.5 m/s^2
    command.left_m_s = speed - 0.2 * share * turn;
    command.right_m_s = speed + 0.2 * share * turn;
    if (plant->step(command, kDriveStep_s) != Status::ok) break;
  }
  if (result.jobs > 0) result.units /= result.jobs;
  return result;
}

/// Postures that a mission would hold: none is made for one of the courses.
inline constexpr FlipperSet kFixedPostures[] = {
    {{0, 0, 0, 0}},         {{0.4, 0.4, 0.4, 0.4}},   {{0.7, 0.7, 0, 0}},        {{0.7, 0.7, 0.4, 0.4}},
    {{1.2, 1.2, 1.2, 1.2}}, {{0.3, 0.3, -0.3, -0.3}}, {{-0.2, -0.2, -0.2, -0.2}}};

}  // namespace sortie::planner
