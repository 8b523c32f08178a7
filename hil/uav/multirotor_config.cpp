// SPDX-License-Identifier: BSD-3-Clause
// Parameters of the hexacopters of RotorS.
#include "hil/uav/multirotor_config.hpp"

#include "rt/math.hpp"

namespace sortie::hil {
namespace {

// Six rotors at 30, 90, 150, -150, -90, -30 degrees, turning +, -, +, -, +, -.
void place_hexagon(MultirotorConfig& config, double arm_m, double height_m) {
  constexpr double kDegrees[6] = {30, 90, 150, -150, -90, -30};
  constexpr double kPerDegree = 3.14159265358979323846 / 180.0;
  config.rotors = 6;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const rt::SinCos angle = rt::sincos(kDegrees[i] * kPerDegree);
    config.rotor[i] = {{arm_m * angle.cos, arm_m * angle.sin, height_m}, i % 2 == 0 ? 1.0 : -1.0};
  }
}

}  // namespace

MultirotorConfig firefly_plant() {
  MultirotorConfig config;
  config.name = "firefly";
  config.frame_mass_kg = 1.5;
  config.inertia_kg_m2 = {0.0347563, 0.0458929, 0.0977};
  config.thrust_n_s2 = 8.54858e-6;
  config.moment_m = 0.016;
  config.tau_up_s = 0.0125;
  config.tau_down_s = 0.025;
  config.max_speed_rad_s = 838.0;
  config.drag_n_s2 = 8.06428e-5;
  config.rolling_n_m_s2 = 1e-6;
  place_hexagon(config, 0.215, 0.037);
  return config;
}

MultirotorConfig neo9_plant() {
  MultirotorConfig config;
  config.name = "neo9";
  config.frame_mass_kg = 2.662;
  config.inertia_kg_m2 = {0.0331, 0.0350, 0.0605};
  config.thrust_n_s2 = 6.8e-6;
  config.moment_m = 0.016754;
  config.tau_up_s = 0.0182;
  config.tau_down_s = 0.0182;
  config.max_speed_rad_s = 1047.2;
  config.drag_n_s2 = 2.0673e-4;
  place_hexagon(config, 0.2495, 0.028);
  return config;
}

MultirotorConfig neo11_plant() {
  MultirotorConfig config = neo9_plant();
  config.name = "neo11";
  config.frame_mass_kg = 3.42;
  config.inertia_kg_m2 = {0.060887, 0.0687913, 0.148916};
  config.thrust_n_s2 = 1.269e-5;
  // Its xacro file puts the rotors off the regular hexagon that the controllers assume.
  constexpr double kHeight = 0.028;
  const Vec3 places[6] = {{0.247, 0.1506, kHeight},      {-0.00067, 0.28929, kHeight},
                          {-0.2501, 0.1454, kHeight},    {-0.2501, -0.1454, kHeight},
                          {-0.00067, -0.28929, kHeight}, {0.247, -0.1506, kHeight}};
  for (std::uint32_t i = 0; i < 6; ++i) config.rotor[i].place_m = places[i];
  return config;
}

double total_mass_kg(const MultirotorConfig& config) {
  return config.frame_mass_kg + static_cast<double>(config.rotors) * config.rotor_mass_kg;
}

Vec3 total_inertia_kg_m2(const MultirotorConfig& config) {
  Vec3 inertia = config.inertia_kg_m2;
  for (std::uint32_t i = 0; i < config.rotors; ++i) {
    const Vec3& r = config.rotor[i].place_m;
    inertia.x += config.rotor_mass_kg * (r.y * r.y + r.z * r.z);
    inertia.y += config.rotor_mass_kg * (r.x * r.x + r.z * r.z);
    inertia.z += config.rotor_mass_kg * (r.x * r.x + r.y * r.y);
  }
  return inertia;
}

}  // namespace sortie::hil
