// SPDX-License-Identifier: BSD-3-Clause
// Random trials of the tracked plant: drops that must not gain energy, extremes that must stay finite.
#pragma once

#include "hil/random.hpp"
#include "plant_bench.hpp"
#include "tests/hil/judge/natural_residual.hpp"

namespace sortie::hil {

inline Quat random_attitude(Random& random) {
  const double w = random.normal();
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return normalized({w, x, y, z});
}

inline Vec3 random_vector(Random& random, double size) {
  const double x = random.uniform(-size, size);
  const double y = random.uniform(-size, size);
  const double z = random.uniform(-size, size);
  return {x, y, z};
}

/// Drops the vehicle in a random attitude with random velocities on rubble, belts still, for 1.5 s. Returns
/// the largest gain of energy in a step, relative to what it had at first; what the correction of depths put
/// in is no gain.
inline double gain_of_drop(std::uint64_t seed) {
  Random random(seed, 0x64726f70);
  PlantConfig config;
  config.vehicle.mode = random.chance(0.5) ? ContactMode::csm : ContactMode::belt;
  config.vehicle.friction = random.uniform(0.0, 1.5);
  for (double& angle : config.start_flipper_rad) angle = random.uniform(-1.5, 1.5);
  const double dt = random.chance(0.5) ? 1e-3 : 5e-3;
  PlantBench bench(config, dt, [&](PlantScene& scene) {
    PlantBench::on_plane(scene);
    REQUIRE(add_rubble(scene, {{-1, 0, 0}, 0}, 2, 2, 20, seed) == Status::ok);
  });
  const Quat attitude = random_attitude(random);
  Generalised u;
  u.linear = random_vector(random, 1.0);
  u.angular = random_vector(random, 3.0);
  bench.plant->place({0, 0, 1.2}, attitude, u);
  bench.step(0, 0);
  double before = bench.plant->report().kinetic_j + bench.plant->report().potential_j;
  const double scale = before;
  const long steps = std::lround(1.5 / dt);
  double worst = 0.0;
  for (long i = 0; i < steps; ++i) {
    bench.step(0, 0);
    const StepReport& report = bench.plant->report();
    const double now = report.kinetic_j + report.potential_j;
    const double gain = now - before - std::max(0.0, report.correction_j);
    if (gain > worst) worst = gain;
    before = now;
  }
  return worst / scale;
}

/// What became of a shaken vehicle.
struct Shaken {
  long first_not_finite{-1};  ///< step, or -1
  std::uint64_t rejected{};   ///< states that the plant refused
  std::uint64_t wrong{};      ///< answers that the solver took for good, and whose impulses say otherwise
};

/// Random configs, scenes, commands and step sizes; a new vehicle every 200 steps.
inline Shaken shake(std::uint64_t seed, long steps) {
  Shaken result;
  Random random(seed, 0x7368616b);
  std::unique_ptr<PlantBench> bench;
  for (long i = 0; i < steps && result.first_not_finite < 0; ++i) {
    if (i % 200 == 0) {
      if (bench) result.rejected += bench->plant->counters().rejected;
      PlantConfig config;
      config.vehicle.mode = random.chance(0.5) ? ContactMode::csm : ContactMode::belt;
      config.vehicle.mass_scale = std::exp(random.uniform(-4.6, 6.9));
      config.vehicle.friction = random.chance(0.2) ? 0.0 : random.uniform(0.0, 10.0);
      config.gravity_m_s2 = random.uniform(0.0, 50.0);
      bench = std::make_unique<PlantBench>(config, 1e-3, [&](PlantScene& scene) {
        PlantBench::on_plane(scene);
        REQUIRE(add_rubble(scene, {{-1, 0, 0}, 0}, 2, 2, 40, random.bits()) == Status::ok);
      });
      const Vec3 start = random_vector(random, 0.5);
      const Quat attitude = random_attitude(random);
      Generalised u;
      u.linear = random_vector(random, 10.0);
      u.angular = random_vector(random, 20.0);
      bench->plant->place({start.x, start.y, 0.3 + start.z}, attitude, u);
    }
    bench->dt_s = random.uniform(1e-4, 0.02);
    for (double& angle : bench->command.flipper_rad) angle = random.uniform(-6.0, 6.0);
    const double left = random.uniform(-3, 3);
    const double right = random.uniform(-3, 3);
    bench->step(left, right);
    const ContactProblem& problem = bench->plant->problem();
    const double pull_ns = bench->plant->model().mass_kg() * 10.0 * bench->dt_s;
    if (bench->plant->report().solver.converged &&
        !(natural_residual(problem, problem.compliance) <= 1e-3 * pull_ns))
      ++result.wrong;
    const PlantState& state = bench->plant->state();
    bool finite = std::isfinite(dot(state.velocity, state.velocity)) &&
                  std::isfinite(norm(state.com_world_m)) &&
                  std::fabs(norm(Vec3{state.q_world_body.x, state.q_world_body.y, state.q_world_body.z})) <=
                      1.0 + 1e-12;
    for (const ContactPoint& c : bench->plant->contacts())
      finite = finite && std::isfinite(norm(c.impulse_ns));
    if (!finite) result.first_not_finite = i;
  }
  return result;
}

}  // namespace sortie::hil
