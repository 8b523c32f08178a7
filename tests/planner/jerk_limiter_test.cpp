// SPDX-License-Identifier: BSD-3-Clause
// The jerk limiter against a search through all motions on a lattice, against the closed form of continuous
// time, and against its own promises under random set-points.
#include "planner/jerk_limiter.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace {
using namespace sortie::planner;

/// Steps to come from rest at 0 to rest at exactly `target`, or more than `most`.
int steps_to(double target, const RampLimits& limits, double dt_s, int most) {
  JerkLimiter axis;
  for (int i = 1; i <= most; ++i) {
    axis.step(target, limits, dt_s);
    if (axis.value == target && axis.rate == 0.0) return i;
  }
  return most + 1;
}

/// Brute force: the fewest steps on the lattice a = k q, v = m q dt / 2, with q one step of jerk, through
/// every motion that keeps |k| <= most_rate. From rest at 0 to rest at `goal`.
int fewest_steps(int goal, int most_rate) {
  std::set<std::pair<int, int>> seen{{0, 0}};
  std::vector<std::pair<int, int>> front{{0, 0}};
  for (int steps = 1; steps < 200; ++steps) {
    std::vector<std::pair<int, int>> next;
    for (const auto& [v, a] : front) {
      for (int change = -1; change <= 1; ++change) {
        const int rate = a + change;
        if (std::abs(rate) > most_rate) continue;
        const std::pair<int, int> state{v + a + rate, rate};
        if (std::abs(state.first) > 2 * std::abs(goal) + 50 || !seen.insert(state).second) continue;
        if (state == std::pair<int, int>{goal, 0}) return steps;
        next.push_back(state);
      }
    }
    front = std::move(next);
  }
  return 200;
}

/// Time from rest to rest over `way` in continuous time: a trapezoid of acceleration, or a triangle.
double shortest_time(double way, const RampLimits& limits) {
  const double ramp = limits.acceleration / limits.jerk;
  const double full = limits.acceleration * ramp;
  return way <= full ? 2.0 * std::sqrt(way / limits.jerk) : way / limits.acceleration + ramp;
}
}  // namespace

TEST_CASE("No motion on the lattice reaches a set-point in fewer steps") {
  const double dt = 0.01;
  for (const int most_rate : {1, 2, 3, 5, 9}) {
    const RampLimits limits{4.0 * most_rate, 400.0};  // one step of jerk is 4
    for (int goal = 1; goal <= 60; ++goal) {
      const int fewest = fewest_steps(goal, most_rate);
      INFO("rates up to " << most_rate << ", goal " << goal);
      if (fewest < 200) REQUIRE(steps_to(goal * 0.5 * 4.0 * dt, limits, dt, 300) <= fewest);
    }
  }
}

TEST_CASE("With finer steps the ramp becomes the time-optimal one, and lands on the set-point exactly") {
  for (const double way : {0.001, 0.03, 0.05, 0.4, 2.0, -0.7}) {
    const RampLimits limits{0.5, 5.0};
    const double best = shortest_time(std::fabs(way), limits);
    for (const double dt : {0.02, 0.005, 0.001, 0.0001}) {
      const int steps = steps_to(way, limits, dt, 100'000);
      INFO("way " << way << ", dt " << dt);
      CHECK(steps * dt <= best + 2.0 * dt);
      CHECK(steps * dt >= best - 2.0 * dt);
    }
  }
}

TEST_CASE("A step of 10 ms goes where ten steps of 1 ms with the same jerk go") {
  std::mt19937_64 random(5);
  JerkLimiter coarse;
  const RampLimits limits{0.8, 6.0};
  double target = 0;
  for (int i = 0; i < 20'000; ++i) {
    if (random() % 150 == 0) target = static_cast<double>(random() % 2001) * 1e-3 - 1.0;
    const JerkLimiter before = coarse;
    coarse.step(target, limits, 0.01);
    const double jerk = (coarse.rate - before.rate) / 0.01;
    JerkLimiter fine = before;
    for (int k = 0; k < 10; ++k) {
      fine.value += fine.rate * 0.001 + 0.5 * jerk * 0.001 * 0.001;
      fine.rate += jerk * 0.001;
    }
    REQUIRE(fine.value == Approx(coarse.value).margin(1e-9));
    REQUIRE(fine.rate == Approx(coarse.rate).margin(1e-9));
  }
}

TEST_CASE("Random set-points in the middle of ramps: limits hold, nothing is passed, every goal is reached") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    const auto draw = [&random](double low, double high) {
      return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    const RampLimits limits{draw(0.05, 5.0), draw(0.5, 100.0)};
    const double dt = draw(0.0005, 0.02);
    const double most = 1.0;
    JerkLimiter axis;
    for (int leg = 0; leg < 60; ++leg) {
      const double target = random() % 5 == 0 ? axis.value : draw(-most, most);
      // How far a set-point that moved back must be passed: until the rate has gone.
      const double rest = axis.rest_value(limits.jerk, dt);
      const double high = std::max({axis.value, rest, target}) + 1e-9;
      const double low = std::min({axis.value, rest, target}) - 1e-9;
      const int most_steps =
          static_cast<int>(3.0 * (shortest_time(4.0, limits) + limits.acceleration / limits.jerk) / dt) + 20;
      const int steps = random() % 3 == 0 ? most_steps : static_cast<int>(random() % 40);
      for (int i = 0; i < steps; ++i) {
        const JerkLimiter before = axis;
        axis.step(target, limits, dt);
        REQUIRE(std::fabs(axis.rate) <= limits.acceleration * (1 + 1e-12));
        REQUIRE(std::fabs(axis.rate - before.rate) <= limits.jerk * dt * (1 + 1e-8));
        REQUIRE(axis.value <= high);
        REQUIRE(axis.value >= low);
        if (before.value == target && before.rate == 0.0) REQUIRE(axis.value == target);  // and stays
      }
      if (steps == most_steps) {
        REQUIRE(axis.value == target);
        REQUIRE(axis.rate == 0.0);
      }
    }
  }
}

TEST_CASE("A rate above a limit that was lowered is led down by the jerk, not cut") {
  JerkLimiter axis;
  for (int i = 0; i < 100; ++i) axis.step(10.0, {2.0, 4.0}, 0.01);
  REQUIRE(axis.rate == Approx(2.0));
  for (int i = 0; i < 200; ++i) {
    const double before = axis.rate;
    axis.step(10.0, {0.5, 4.0}, 0.01);
    REQUIRE(std::fabs(axis.rate - before) <= 0.04 + 1e-12);
  }
  CHECK(axis.rate == Approx(0.5));
}

TEST_CASE("What an axis runs out by is what it does when it is told to rest") {
  std::mt19937_64 random(9);
  for (int i = 0; i < 2000; ++i) {
    JerkLimiter axis{0.3, static_cast<double>(random() % 4001) * 1e-3 - 2.0};
    const double dt = 0.001 * static_cast<double>(1 + random() % 20);
    const double jerk = 0.5 * static_cast<double>(1 + random() % 40);
    const double rest = axis.rest_value(jerk, dt);
    double value = axis.value;
    for (double rate = axis.rate; rate != 0.0;) {
      const double next = rate - std::clamp(rate, -jerk * dt, jerk * dt);
      value += 0.5 * (rate + next) * dt;
      rate = next;
    }
    REQUIRE(rest == Approx(value).margin(1e-11));
    REQUIRE(axis.can_keep(rest, {10.0, jerk}, dt));
    REQUIRE((axis.rate == 0.0 || !axis.can_keep(axis.value, {10.0, jerk}, dt)));
  }
}
