// SPDX-License-Identifier: BSD-3-Clause
// The flight controller's parts: profile, flatness, allocation; and what it makes of absurd inputs.
#include "planner/uav_control/uav_control.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "rt/posix/heap_trap.hpp"

namespace {
using namespace sortie;
using planner::FlatReference;
using planner::GoalProfile;
using rt::Vector3;

constexpr double kProfileStep = 0.01;

planner::UavModel some_hexacopter() {
  planner::UavModel model;
  model.mass_kg = 2.0;
  model.inertia_kg_m2 = {0.03, 0.035, 0.06};
  model.thrust_n_s2 = 9e-6;
  model.moment_m = 0.016;
  model.tau_up_s = model.tau_down_s = 0.02;
  model.max_speed_rad_s = 900;
  planner::place_rotors(model, 6, 0.22, 0.52);
  return model;
}

double draw_between(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Vector3 draw_vector(std::mt19937_64& random, double most) {
  const double x = draw_between(random, -most, most);
  const double y = draw_between(random, -most, most);
  const double z = draw_between(random, -most, most);
  return {x, y, z};
}
}  // namespace

TEST_CASE("Goals that jump about give a motion whose derivatives belong together and keep their limits") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    const planner::ProfileLimits limits;
    auto profile = std::make_unique<GoalProfile>(limits, kProfileStep);
    FlatReference last = profile->now();
    for (int k = 0; k < 3000; ++k) {
      if (draw_between(random, 0, 1) < 0.02) {
        const double yaw = draw_between(random, -3, 3);
        REQUIRE(profile->set_goal(draw_vector(random, 5), yaw) == Status::ok);
      }
      if (draw_between(random, 0, 1) < 0.003) {
        FlatReference moving = last;
        moving.v_m_s = draw_vector(random, 1.5);
        moving.a_m_s2 = moving.j_m_s3 = {};
        profile->brake(moving);
        last = profile->now();
        continue;
      }
      profile->step();
      const FlatReference& now = profile->now();
      REQUIRE(planner::is_finite(now));
      REQUIRE(rt::norm(now.v_m_s) < std::hypot(2.0, 1.5) + 1.5);
      REQUIRE(rt::norm(now.a_m_s2) < 2.0 * 4.5 * 1.25 + 0.1);
      // Position follows from velocity, velocity from acceleration, by Taylor's series over the step.
      const Vector3 p = last.p_m + 0.5 * kProfileStep * (last.v_m_s + now.v_m_s) +
                        (kProfileStep * kProfileStep / 12) * (last.a_m_s2 - now.a_m_s2);
      REQUIRE(rt::norm(p - now.p_m) < 1e-5);
      const Vector3 v = last.v_m_s + 0.5 * kProfileStep * (last.a_m_s2 + now.a_m_s2);
      REQUIRE(rt::norm(v - now.v_m_s) < 0.03);
      last = now;
    }
    for (int k = 0; k < 2500; ++k) profile->step();
    CHECK(rt::norm(profile->now().v_m_s) < 1e-6);
    CHECK(std::fabs(rt::wrap_angle(profile->goal_yaw_rad() - profile->now().yaw_rad)) < 1e-3);
    CHECK(rt::norm(profile->now().p_m - profile->goal_m()) < 1e-9);
  }
}

TEST_CASE("A profile neither overshoots nor loses its way after braking") {
  auto profile = std::make_unique<GoalProfile>(planner::ProfileLimits{}, kProfileStep);
  REQUIRE(profile->set_goal({1, 0, 0}, 0) == Status::ok);
  double most = 0;
  for (int k = 0; k < 300; ++k) {
    profile->step();
    most = std::max(most, profile->now().p_m.x);
  }
  CHECK(most <= 1.0 + 1e-12);
  FlatReference moving;
  moving.p_m = {3, 2, 5};
  moving.v_m_s = {1, 0, 0};
  profile->brake(moving);
  Vector3 last = moving.p_m;
  for (int k = 0; k < 1500; ++k) {
    profile->step();
    REQUIRE(rt::norm(profile->now().p_m - last) < 0.04);  // nothing jumps
    last = profile->now().p_m;
  }
  CHECK(rt::norm(last - Vector3{1, 0, 0}) < 1e-9);
  CHECK(profile->set_goal({1e9, 0, 0}, 0) == Status::out_of_range);
  CHECK(profile->set_goal({std::nan(""), 0, 0}, 0) == Status::not_finite);
}

TEST_CASE("A stop while a profile brakes lets it brake, and it stays where that ends") {
  for (const int before : {0, 1, 20}) {
    CAPTURE(before);
    auto profile = std::make_unique<GoalProfile>(planner::ProfileLimits{}, kProfileStep);
    FlatReference moving;
    moving.p_m = {3, 2, 5};
    moving.v_m_s = {2, 0, -0.5};
    moving.a_m_s2 = {-0.5, 0, 0};
    profile->rest(moving.p_m, 0);
    profile->brake(moving);
    for (int k = 0; k < before; ++k) profile->step();
    Vector3 last = profile->now().v_m_s;
    profile->stop();
    for (int k = 0; k < 500; ++k) {
      profile->step();
      REQUIRE(rt::norm(profile->now().v_m_s - last) < 0.05);
      REQUIRE(profile->now().v_m_s.x > -1e-9);  // it does not come back
      last = profile->now().v_m_s;
    }
    CHECK(rt::norm(last) < 1e-9);
    CHECK(profile->now().p_m.x > 3.5);
    CHECK(rt::norm(profile->now().p_m - profile->goal_m()) < 1e-9);
  }
}

TEST_CASE("Flat rates and accelerations agree with differences of the attitude") {
  const auto reference = [](double t) {
    FlatReference r;
    const double w = 1.3;
    const Vector3 size{1.0, 0.7, 0.4};
    const auto wave = [&](double phase, int order) {
      double value = order % 2 == 0 ? rt::sin(w * t + phase) : rt::cos(w * t + phase);
      if (order % 4 >= 2) value = -value;
      for (int i = 0; i < order; ++i) value *= w;
      return value;
    };
    const auto all = [&](int order) {
      return Vector3{size.x * wave(0, order), size.y * wave(1, order), size.z * wave(2, order)};
    };
    r.p_m = all(0);
    r.v_m_s = all(1);
    r.a_m_s2 = all(2);
    r.j_m_s3 = all(3);
    r.s_m_s4 = all(4);
    return r;
  };
  const auto body_at = [&](double t) {
    const FlatReference r = reference(t);
    return planner::flat_body(r.a_m_s2 + Vector3{0, 0, 9.81}, r, rt::sincos(0.0));
  };
  const double h = 1e-4;
  for (double t = 0.1; t < 5; t += 0.37) {
    const planner::FlatBody body = body_at(t);
    const planner::FlatBody before = body_at(t - h);
    const planner::FlatBody after = body_at(t + h);
    const Vector3 z_rate = (0.5 / h) * (after.z - before.z);
    CHECK(rt::dot(z_rate, body.x) == Approx(body.w_rad_s.y).margin(1e-6));
    CHECK(-rt::dot(z_rate, body.y) == Approx(body.w_rad_s.x).margin(1e-6));
    const Vector3 w_rate = (0.5 / h) * (after.w_rad_s - before.w_rad_s);
    // Without a turn of the heading w_z is small but not zero: the reference leaves it out.
    CHECK(w_rate.x == Approx(body.alpha_rad_s2.x).margin(0.15));
    CHECK(w_rate.y == Approx(body.alpha_rad_s2.y).margin(0.15));
  }
}

TEST_CASE("Allocation: what fits is met, what does not is met where it matters, against a slow twin") {
  const planner::UavModel model = some_hexacopter();
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    planner::Allocation allocation(model);
    if (seed % 3 == 0) REQUIRE(allocation.lose(static_cast<std::uint32_t>(seed / 3 % 6)));
    const double weight = model.mass_kg * 9.81;
    const double thrust = draw_between(random, 0.2, 1.6) * weight;
    const Vector3 torque = draw_vector(random, seed % 2 == 0 ? 0.3 : 4.0);
    const planner::RotorThrusts shared = allocation.share({thrust, torque});
    double at[6];
    for (std::uint32_t i = 0; i < 6; ++i) {
      at[i] = shared.force_n[i];
      REQUIRE(at[i] >= 0);
      REQUIRE(at[i] <= model.max_thrust_n() * (1 + 1e-12));
      if (allocation.lost(i)) REQUIRE(at[i] == 0);
    }
    // No single rotor, and no pair, can be moved to a better place: the weighted error is at its least.
    const double arm = 0.22;
    const double weights[4] = {10, 100 / arm, 100 / arm, 1 / model.moment_m};
    const auto cost = [&](const double* force) {
      const planner::RotorWrench made = allocation.wrench(force);
      const double errors[4] = {made.thrust_n - thrust, made.torque_n_m.x - torque.x,
                                made.torque_n_m.y - torque.y, made.torque_n_m.z - torque.z};
      double sum = 0;
      for (int k = 0; k < 4; ++k) sum += weights[k] * weights[k] * errors[k] * errors[k];
      for (int i = 0; i < 6; ++i) sum += 1e-6 * force[i] * force[i];
      return sum;
    };
    const double best = cost(at);
    for (int trial = 0; trial < 200; ++trial) {
      double other[6];
      const double reach = trial % 2 == 0 ? 0.3 : 0.01;
      for (std::uint32_t i = 0; i < 6; ++i) {
        const double moved = at[i] + draw_between(random, -reach, reach);
        other[i] = allocation.lost(i) ? 0.0 : std::min(std::max(moved, 0.0), model.max_thrust_n());
      }
      REQUIRE(cost(other) >= best - 1e-6 * (1 + best));
    }
  }
}

TEST_CASE("Allocation: what cannot be met is told") {
  const planner::UavModel model = some_hexacopter();
  const planner::Allocation allocation(model);
  const double weight = model.mass_kg * 9.81;
  const double most = 6 * model.max_thrust_n();
  CHECK_FALSE(allocation.share({weight, {0.1, -0.1, 0.01}}).limited);
  CHECK(allocation.share({1.5 * most, {0, 0, 0}}).limited);
  CHECK(allocation.share({-weight, {0, 0, 0}}).limited);
  CHECK(allocation.share({weight, {100, 0, 0}}).limited);
  CHECK(allocation.share({weight, {0, -100, 0}}).limited);
}

TEST_CASE("Allocation: a rotor that is lost makes nothing, whatever it is told, and four are needed") {
  const planner::UavModel model = some_hexacopter();
  planner::Allocation whole(model);
  planner::Allocation allocation(model);
  double told[6] = {1, 2, 3, 4, 5, 6};
  REQUIRE(allocation.lose(2));
  CHECK_FALSE(allocation.lose(2));
  CHECK_FALSE(allocation.lose(6));
  const planner::RotorWrench made = allocation.wrench(told);
  told[2] = 0;
  const planner::RotorWrench expected = whole.wrench(told);
  CHECK(made.thrust_n == expected.thrust_n);
  CHECK(rt::norm(made.torque_n_m - expected.torque_n_m) == 0);
  CHECK(made.thrust_n == 18);
  REQUIRE(allocation.lose(4));
  CHECK_FALSE(allocation.lose(0));
}

TEST_CASE("Whatever the state and the goals, commands are finite and in range, and nothing takes the heap") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  planner::UavControlConfig config;
  config.model = some_hexacopter();
  auto control = std::make_unique<planner::UavControl>(config);
  REQUIRE(control->status() == Status::ok);
  std::mt19937_64 random(9);
  const double infinity = std::numeric_limits<double>::infinity();
  const double strange[] = {std::nan(""), infinity, -infinity, 1e300, -1e18, 1e-320};
  rt::UavState state;
  state.stamp_ns = 1;
  REQUIRE(control->start(state) == Status::ok);
  bool good = true;
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int k = 0; k < 5000; ++k) {
      state.stamp_ns += 10'000'000;
      rt::store(draw_vector(random, 3), state.p_world_m);
      rt::store(draw_vector(random, 8), state.v_world_m_s);
      rt::store(draw_vector(random, 10), state.w_body_rad_s);
      rt::store(draw_vector(random, 20), state.d_world_m_s2);
      rt::store(rt::exp_rotation(draw_vector(random, 3)), state.q_world_body);
      if (k % 7 == 0) state.p_world_m[k % 3] = strange[k % 6];
      if (k % 11 == 0) state.w_body_rad_s[k % 3] = strange[k % 6];
      (void)control->set_goal({k % 5 == 0 ? strange[k % 6] : 1.0, 1e4, -3},
                              k % 13 == 0 ? strange[k % 6] : 2.0);
      FlatReference wild;
      wild.p_m = draw_vector(random, 1);
      wild.a_m_s2 = draw_vector(random, 40);
      wild.s_m_s4 = {strange[k % 6], 0, 0};
      (void)control->track(wild);
      if (k % 997 == 0) control->land();
      rt::RotorCommand command;
      (void)control->update(state, command);
      for (std::uint32_t i = 0; i < 6; ++i)
        good = good && command.speed_rad_s[i] >= 0 && command.speed_rad_s[i] <= 900;
    }
    calls = scope.calls();
  }
  CHECK(good);
  CHECK(calls == 0);
  CHECK(control->counters().states_refused > 100);
  CHECK(control->counters().goals_refused > 100);
}

TEST_CASE("A state is flown by once, and a lost one is no place: it sinks level and lands when found again") {
  planner::UavControlConfig config;
  config.model = some_hexacopter();
  const auto control = std::make_unique<planner::UavControl>(config);
  rt::UavState state;
  state.stamp_ns = 10'000'000;
  state.p_world_m[2] = 5;
  state.verdict = rt::UavVerdict::good;
  REQUIRE(control->start(state) == Status::ok);
  rt::RotorCommand command;
  REQUIRE(control->update(state, command) == Status::ok);
  CHECK(control->phase() == planner::UavPhase::hold);
  CHECK(control->update(state, command) == Status::time_repeated);
  state.stamp_ns -= 1;
  CHECK(control->update(state, command) == Status::time_backwards);
  CHECK(control->counters().states_refused == 2);
  state.stamp_ns += 10'000'001;
  state.verdict = rt::UavVerdict::lost;
  REQUIRE(control->update(state, command) == Status::ok);
  CHECK(control->phase() == planner::UavPhase::blind);
  CHECK(control->reference().v_m_s.z == -config.sink_m_s);
  for (std::uint32_t i = 1; i < 6; ++i) CHECK(command.speed_rad_s[i] > 0);
  state.stamp_ns += 10'000'000;
  state.verdict = rt::UavVerdict::good;
  REQUIRE(control->update(state, command) == Status::ok);
  CHECK(control->phase() == planner::UavPhase::land);
}

TEST_CASE("A vehicle that cannot fly is told so and never gets a command") {
  planner::UavControlConfig config;
  const auto control = std::make_unique<planner::UavControl>(config);
  CHECK(control->status() != Status::ok);
  CHECK(control->start({}) != Status::ok);
  rt::RotorCommand command;
  CHECK(control->update({}, command) != Status::ok);
  for (const double speed : command.speed_rad_s) CHECK(speed == 0);
}
