// SPDX-License-Identifier: BSD-3-Clause
// The simulated vehicle where its equations are stiff, or have nothing to hold on to.
#include <algorithm>
#include <cmath>
#include <memory>

#include "hil/plant/tracked_plant.hpp"
#include "hil/suspension.hpp"
#include "hil/track_drive.hpp"
#include "rt/math.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

constexpr double kGravity = 9.81;
constexpr double kSlope = 0.35;
constexpr double kRideHeight = 0.07192;

// A vehicle with its brakes on that stands on a plane.
struct StandingVehicle {
  hil::PlantScene scene;
  std::unique_ptr<hil::TrackedPlant> plant;

  StandingVehicle(double slope_rad, double friction, double below_m) {
    const hil::Vec3 normal{-std::sin(slope_rad), 0, std::cos(slope_rad)};
    static_cast<void>(scene.add_half_space(normal, {0, 0, 0}));
    hil::PlantConfig config;
    config.vehicle.friction = friction;
    config.start_q_world_body = hil::from_yaw_pitch_roll(0, -slope_rad, 0);
    config.start_m = (kRideHeight - below_m) * normal;
    plant = std::make_unique<hil::TrackedPlant>(config, scene);
  }
  void stand(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i)
      static_cast<void>(plant->step(hil::PlantCommand{}, 1e-3));
  }
  double speed() const { return norm(plant->velocity_world_m_s({})); }
};

}  // namespace

StabilityFigures no_friction() {
  const auto vehicle = std::make_unique<StandingVehicle>(kSlope, 0.0, 0.0);
  vehicle->stand(0.2);
  const double before = vehicle->speed();
  vehicle->stand(1.0);
  const double wanted = kGravity * std::sin(kSlope);
  // Friction's cone made a ball: side forces over mu.
  const double mu = 0.0;
  const double side = mu * kGravity * std::cos(kSlope);
  const double on_ball = side / mu;
  return {std::fabs(vehicle->speed() - before - wanted), std::fabs(wanted - mu * on_ball - wanted)};
}

StabilityFigures high_friction() {
  const auto vehicle = std::make_unique<StandingVehicle>(kSlope, 10.0, 0.0);
  vehicle->stand(0.5);
  const hil::Vec3 start = vehicle->plant->p_world_body_m();
  vehicle->stand(5.0);
  // A mass with friction mu N against its speed, step by step: it overshoots to and fro and drifts.
  constexpr double kDt = 1e-3;
  double speed = 0;
  double way = 0;
  for (int i = 0; i < 5000; ++i) {
    const double grip = 10.0 * kGravity * std::cos(kSlope);
    const double sign = speed > 0 ? 1.0 : speed < 0 ? -1.0 : 0.0;
    speed += kDt * (kGravity * std::sin(kSlope) - sign * grip);
    way += kDt * std::fabs(speed);
  }
  return {norm(vehicle->plant->p_world_body_m() - start), way};
}

StabilityFigures fast_motor() {
  constexpr double kLag = 1e-4;
  constexpr double kStep = 0.02;
  hil::TrackDrive drive(kLag, 1e9, kStep);
  double naive = 0;
  for (int i = 0; i < 10; ++i) {
    drive.advance(0.5);
    naive += kStep / kLag * (0.5 - naive);
  }
  return {std::fabs(drive.speed_m_s() - 0.5), std::fabs(naive - 0.5)};
}

StabilityFigures stiff_suspension() {
  constexpr double kHertz = 1000;
  constexpr double kStep = 0.02;
  const double w = 6.283185307179586 * kHertz;
  hil::Suspension suspension(kHertz, kStep);
  suspension.reset(0.0);
  double value = 0;
  double rate = 0;
  for (int i = 0; i < 10; ++i) {
    suspension.advance(0.3);
    const double pull = -2 * w * rate - w * w * (value - 0.3);
    value += kStep * rate;
    rate += kStep * pull;
  }
  return {std::fabs(suspension.value() - 0.3), std::fabs(value - 0.3)};
}

StabilityFigures heavy_on_light() {
  // 28 kg stand on four flippers of a gram each, held by their servos.
  hil::PlantScene scene;
  static_cast<void>(scene.add_half_space({0, 0, 1}, {0, 0, 0}));
  hil::PlantConfig config;
  hil::PlantCommand command;
  const double lighter = 1e-3 / config.vehicle.flipper_mass_kg;
  config.vehicle.flipper_mass_kg *= lighter;
  config.vehicle.flipper_inertia_kg_m2 = lighter * config.vehicle.flipper_inertia_kg_m2;
  for (int i = 0; i < 4; ++i) config.start_flipper_rad[i] = command.flipper_rad[i] = -0.9;
  config.start_m = {0, 0, 0.30};
  const auto plant = std::make_unique<hil::TrackedPlant>(config, scene);
  StabilityFigures moved;
  double before = 0;
  for (int i = 0; i < 5000; ++i) {
    static_cast<void>(plant->step(command, 1e-3));
    const double height = plant->p_world_body_m().z;
    if (i == 2000) before = height;
    if (i > 2000) keep_worst(moved.ours, std::fabs(height - before));
  }
  // A gram under 28 kg, both contacts by ten sequential impulses a step, from nothing each time.
  constexpr double kDt = 1e-3;
  constexpr double kLight = 1e-3;
  constexpr double kHeavy = 28.0;
  double speed[2] = {0, 0};
  double place[2] = {0, 0};
  for (int i = 0; i < 3000; ++i) {
    for (double& v : speed) v -= kDt * kGravity;
    for (int sweep = 0; sweep < 10; ++sweep) {
      speed[0] = std::max(speed[0], 0.0);
      const double closing = speed[0] - speed[1];
      if (closing > 0) {
        const double impulse = closing / (1 / kLight + 1 / kHeavy);
        speed[0] -= impulse / kLight;
        speed[1] += impulse / kHeavy;
      }
    }
    for (int k = 0; k < 2; ++k) place[k] += kDt * speed[k];
  }
  moved.naive = std::fabs(place[1]);
  return moved;
}

StabilityFigures deep_penetration() {
  constexpr double kDeep = 0.05;
  const auto vehicle = std::make_unique<StandingVehicle>(0.0, 0.7, kDeep);
  // A spring that carries the weight at 0.1 mm, in the same steps.
  constexpr double kDt = 1e-3;
  double height = -kDeep;
  double speed = 0;
  StabilityFigures highest;
  for (int i = 0; i < 3000; ++i) {
    vehicle->stand(kDt);
    const double above = vehicle->plant->p_world_body_m().z - kRideHeight;
    keep_worst(highest.ours, above);
    speed += kDt * (kGravity / 1e-4 * std::max(0.0, -height) - kGravity);
    height += kDt * speed;
    keep_worst(highest.naive, height);
  }
  return highest;
}

}  // namespace sortie::bench
