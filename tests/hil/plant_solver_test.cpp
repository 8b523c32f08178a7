// SPDX-License-Identifier: BSD-3-Clause
// The plant's contact solver beside a dense solver over impulses, and its mass matrix beside a sum over
// points.
#include "hil/random.hpp"
#include "plant_bench.hpp"
#include "tests/hil/judge/natural_residual.hpp"
#include "tests/hil/judge/reference_solver.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

/// Kinetic energy of the vehicle as a sum over its rigid parts, each moved on its own.
double energy_by_parts(const VehicleModel& model, const double (&angle)[kFlippers], const Generalised& u) {
  const VehicleConfig& c = model.config();
  double energy = 0.0;
  const auto add = [&](double mass, const Vec3& at, const Vec3& inertia, const Matrix3& axes, const Vec3& w,
                       const Vec3& v) {
    const Vec3 local = back(axes, w);
    energy += 0.5 * mass * dot(v, v) + 0.5 * (inertia.x * local.x * local.x + inertia.y * local.y * local.y +
                                              inertia.z * local.z * local.z);
    (void)at;
  };
  const Matrix3 body = to_matrix(Quat{});
  add(c.body_mass_kg, c.body_centre_m, c.body_inertia_kg_m2, body, u.angular,
      u.linear + cross(u.angular, c.body_centre_m));
  for (const double side : {1.0, -1.0}) {
    const Vec3 at{c.track_centre_m.x, side * c.track_centre_m.y, c.track_centre_m.z};
    add(c.track_mass_kg, at, c.track_inertia_kg_m2, body, u.angular, u.linear + cross(u.angular, at));
  }
  for (int f = 0; f < kFlippers; ++f) {
    const bool front = f < 2;
    const double turn = front ? -angle[f] : angle[f];  // about +y; positive angles are up
    const Matrix3 axes = to_matrix(from_yaw_pitch_roll(0, turn, 0));
    const Vec3 pivot{front ? 0.25 : -0.25, f % 2 == 0 ? 0.272 : -0.272, 0.0195};
    const Vec3 arm = axes * Vec3{front ? c.flipper_com_m : -c.flipper_com_m, 0, 0};
    const Vec3 own{0, front ? -u.joint[f] : u.joint[f], 0};
    const Vec3 v = u.linear + cross(u.angular, pivot + arm) + cross(own, arm);
    add(c.flipper_mass_kg, pivot + arm, c.flipper_inertia_kg_m2, axes, u.angular + own, v);
  }
  return energy;
}

Generalised random_velocity(Random& random, double size) {
  Generalised u;
  for (double* x : {&u.linear.x, &u.linear.y, &u.linear.z, &u.angular.x, &u.angular.y, &u.angular.z,
                    &u.joint[0], &u.joint[1], &u.joint[2], &u.joint[3]}) {
    *x = random.uniform(-size, size);
  }
  return u;
}

}  // namespace

TEST_CASE("plant: the mass matrix is that of the parts, and its solver inverts it", "[plant]") {
  const VehicleModel model{VehicleConfig{}};
  CHECK(model.mass_kg() == Approx(28.26));
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    double angle[kFlippers];
    for (double& a : angle) a = random.uniform(-4, 4);
    MassState state;
    model.mass_at(angle, state);
    const Generalised u = random_velocity(random, 2.0);
    const Generalised p = multiply(state.matrix, u);
    CHECK(0.5 * dot(u, p) == Approx(energy_by_parts(model, angle, u)).epsilon(1e-12));
    Generalised again;
    REQUIRE(solve(state.matrix, p, again));
    CHECK(std::sqrt(dot(again - u, again - u)) < 1e-12);
    // dT/dq against a difference of energies.
    double force[kFlippers];
    model.joint_motion_force(state, u, force);
    for (int f = 0; f < kFlippers; ++f) {
      double moved[kFlippers] = {angle[0], angle[1], angle[2], angle[3]};
      moved[f] += 1e-6;
      const double high = energy_by_parts(model, moved, u);
      moved[f] -= 2e-6;
      CHECK(force[f] == Approx((high - energy_by_parts(model, moved, u)) / 2e-6).margin(1e-6));
    }
  }
}

TEST_CASE("plant: free flight keeps momentum and the energy of turning", "[plant]") {
  PlantConfig config;
  config.gravity_m_s2 = 0.0;
  PlantBench bench(config, 1e-3, [](PlantScene&) {});
  Generalised u;
  u.linear = {0.3, -0.2, 0.5};
  u.angular = {2.0, -3.0, 1.0};
  bench.plant->place({0, 0, 5}, {}, u);
  const auto momentum = [&](Vec3& linear, Vec3& angular) {
    MassState mass;
    bench.plant->model().mass_at(bench.plant->state().flipper_rad, mass);
    const Generalised p = multiply(mass.matrix, bench.plant->state().velocity);
    const Matrix3 turn = to_matrix(bench.plant->state().q_world_body);
    linear = turn * p.linear;
    angular = turn * (p.angular - cross(mass.com_m, p.linear));
  };
  Vec3 linear, angular, linear_after, angular_after;
  momentum(linear, angular);
  bench.step(0, 0);
  const double energy = bench.plant->report().kinetic_j + bench.plant->report().potential_j;
  for (int i = 0; i < 5000; ++i) bench.step(0, 0);
  momentum(linear_after, angular_after);
  CHECK(norm(linear_after - linear) < 1e-11);
  CHECK(norm(angular_after - angular) < 0.02 * norm(angular));
  CHECK(bench.plant->report().kinetic_j + bench.plant->report().potential_j <= energy * (1 + 1e-12));
  CHECK(bench.plant->report().kinetic_j > 0.9 * energy);
}

TEST_CASE("plant: the production solver agrees with the dense one", "[plant][heavy]") {
  const auto mode = GENERATE(ContactMode::csm, ContactMode::belt);
  const auto scene = GENERATE(0, 1, 2);
  CAPTURE(static_cast<int>(mode), scene);
  PlantConfig config;
  config.vehicle.mode = mode;
  config.vehicle.friction = 1.0;
  for (int f = 2; f < kFlippers; ++f) config.start_flipper_rad[f] = -0.1;
  PlantBench bench(config, 2e-3, [scene](PlantScene& s) {
    PlantBench::on_plane(s);
    if (scene == 1) REQUIRE(add_stairs(s, {{0.6, 0, 0}, 0.1}, {}) == Status::ok);
    if (scene == 2) REQUIRE(add_rubble(s, {{0.4, 0, 0}, 0}, 2, 2, 80, 3) == Status::ok);
  });
  const double weight = bench.plant->model().mass_kg() * 9.81 * bench.dt_s;
  int step = 0;
  int close = 0;
  int steps = 0;
  bench.drive(0.3, scene == 0 ? -0.1 : 0.3, 3, 1.0, [&] {
    const ContactProblem& problem = bench.plant->problem();
    const double residual = natural_residual(problem, problem.compliance) / weight;
    ++steps;
    if (residual <= 1e-4) ++close;
    if (bench.plant->report().solver.converged) CHECK(residual < 1e-6);
    if (++step % 100 != 0) return;
    auto judge = std::make_unique<ContactProblem>(problem);
    for (ContactPoint& c : judge->contacts) c.impulse_ns = {};  // the judge is told nothing
    Generalised u;
    const ReferenceReport report = solve_reference(*judge, u, 1e-9 * weight, 20000);
    if (report.residual_ns > 1e-9 * weight) WARN("dense solver stopped at " << report.residual_ns / weight);
    if (report.residual_ns > 1e-9 * weight || !bench.plant->report().solver.converged) return;
    Generalised momentum = problem.momentum;
    for (const ContactPoint& c : problem.contacts) add_impulse(c, c.impulse_ns, momentum);
    for (int j = 0; j < kFlippers; ++j) momentum.joint[j] += problem.drives[j].impulse_nms;
    Generalised v;
    REQUIRE(solve(problem.mass, momentum, v));
    CHECK(norm(v.linear - u.linear) + norm(v.angular - u.angular) < 1e-6);
  });
  CHECK(close == steps);
}
