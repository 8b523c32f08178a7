// SPDX-License-Identifier: BSD-3-Clause
// Drives over planes and obstacles that several proofs of the tracked plant share, none of them symmetric.
#pragma once

#include <vector>

#include "plant_bench.hpp"

namespace sortie::hil {

/// A drive with belts at constant speed after a ramp.
struct ProvingDrive {
  const char* name;
  double friction;
  double left_m_s;
  double right_m_s;
  double seconds;
  double front_rad;  ///< flippers
  double rear_rad;
  Vec3 start_m;
  double start_pitch_rad;
  void (*build)(PlantScene& scene, double side);  ///< side: +1, or -1 for the mirror image
};

/// How it is driven.
struct ProvingWay {
  double dt_s{1e-3};
  ContactMode mode{ContactMode::csm};
  double friction_factor{1.0};
  bool mirrored{false};
  ContactSolver solver{solve_contacts};
};

inline std::vector<ProvingDrive> proving_drives() {
  constexpr double kSlope = 0.35;
  constexpr double kHeight = 0.07192;
  const auto plane = [](PlantScene& s, double) { PlantBench::on_plane(s); };
  const auto ramp = [](PlantScene& s, double) {
    REQUIRE(s.add_half_space({-std::sin(kSlope), 0, std::cos(kSlope)}, {0, 0, 0}) == Status::ok);
  };
  const auto pallet = [](PlantScene& s, double side) {
    PlantBench::on_plane(s);
    REQUIRE(add_pallet(s, {{0.8, 0.1 * side, 0}, 0.1 * side}) == Status::ok);
  };
  const auto up = [](PlantScene& s, double side) {
    PlantBench::on_plane(s);
    REQUIRE(add_stairs(s, {{0.8, 0.1 * side, 0}, 0.05 * side}, {}) == Status::ok);
  };
  const auto down = [](PlantScene& s, double side) {
    PlantBench::on_plane(s);
    REQUIRE(add_stairs(s, {{4 * 0.28, 0.1 * side, 0}, 3.14159265358979 + 0.05 * side}, {}) == Status::ok);
  };
  const auto beam = [](PlantScene& s, double side) {
    PlantBench::on_plane(s);
    const Quat turned = from_yaw_pitch_roll(0.2 * side, 0, 0);
    REQUIRE(s.add_box({1.0, 0, 0.04}, turned, {0.05, 0.6, 0.04}) == Status::ok);
  };
  return {{"plane", 0.7, 0.1, 0.3, 6, 0.5, 0.5, {0, 0, kHeight}, 0, plane},
          {"ramp",
           0.9,
           0.25,
           0.3,
           4,
           0.5,
           0.5,
           {-std::sin(kSlope) * kHeight, 0, std::cos(kSlope) * kHeight},
           -kSlope,
           ramp},
          {"beam", 0.8, 0.3, 0.3, 6, 0.5, 0.5, {0, 0, kHeight}, 0, beam},
          {"pallet", 0.8, 0.2, 0.2, 12, 0.7, 0.15, {0, 0, kHeight}, 0, pallet},
          {"stairs up", 1.2, 0.3, 0.3, 10, 0.7, 0.0, {0, 0, kHeight}, 0, up},
          {"stairs down", 1.0, 0.3, 0.3, 10, 0.3, 0.1, {-0.9, 0, 0.85 + kHeight}, 0, down}};
}

inline PlantBench proving_bench(const ProvingDrive& drive, const ProvingWay& way) {
  PlantConfig config;
  config.vehicle.mode = way.mode;
  config.vehicle.friction = drive.friction * way.friction_factor;
  config.start_m = drive.start_m;
  config.start_q_world_body = from_yaw_pitch_roll(0, drive.start_pitch_rad, 0);
  for (int f = 0; f < kFlippers; ++f) config.start_flipper_rad[f] = f < 2 ? drive.front_rad : drive.rear_rad;
  const double side = way.mirrored ? -1.0 : 1.0;
  return PlantBench(
      config, way.dt_s, [&](PlantScene& scene) { drive.build(scene, side); }, way.solver);
}

/// Where the drive ends; `each` is called after each step.
inline Vec3 prove(PlantBench& bench, const ProvingDrive& drive, const ProvingWay& way,
                  const std::function<void()>& each = {}) {
  const double left = way.mirrored ? drive.right_m_s : drive.left_m_s;
  const double right = way.mirrored ? drive.left_m_s : drive.right_m_s;
  bench.drive(left, right, drive.seconds, 1.0, each);
  return bench.position();
}

inline Vec3 end_of(const ProvingDrive& drive, const ProvingWay& way) {
  PlantBench bench = proving_bench(drive, way);
  return prove(bench, drive, way);
}

}  // namespace sortie::hil
