// SPDX-License-Identifier: BSD-3-Clause
// Rays through hundreds of cells, gains of stiff and half-reachable systems, straight lines.
#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/occupancy/occupancy.hpp"
#include "planner/coverage_table.hpp"
#include "planner/icr_model.hpp"
#include "planner/jerk_limiter.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_model.hpp"
#include "planner/twist_limiter.hpp"
#include "planner/uav_control/dare.hpp"
#include "planner/uav_control/discretise.hpp"
#include "rt/math.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

using planner::Dare;
using planner::DareReport;
using planner::DoubleDouble;
using planner::SmallMatrix;

// A multirotor's horizontal chain behind a motor lag.
template <class T>
Dare<T, 6, 1> lagged_chain(double dt_s, double tau_s, double q, double r) {
  SmallMatrix<T, 6, 6> a;
  SmallMatrix<T, 6, 1> b;
  const double couple[5] = {1, 1, 9.81, 1, 1};
  for (std::size_t i = 0; i < 5; ++i) a(i, i + 1) = T(couple[i]);
  a(5, 5) = T(0.0) - T(1.0) / T(tau_s);
  b(5, 0) = T(1.0) / T(tau_s);
  Dare<T, 6, 1> problem;
  static_cast<void>(planner::discretise(a, b, dt_s, problem.a, problem.b));
  for (std::size_t i = 0; i < 6; ++i) problem.q(i, i) = T(q);
  problem.r(0, 0) = T(r);
  return problem;
}

// Two states of which the input reaches the second alone.
Dare<DoubleDouble, 2, 1> half_reached(double first, double second) {
  Dare<DoubleDouble, 2, 1> problem;
  problem.a(0, 0) = DoubleDouble(first);
  problem.a(1, 1) = DoubleDouble(second);
  problem.b(1, 0) = DoubleDouble(1.0);
  problem.q = SmallMatrix<DoubleDouble, 2, 2>::identity();
  problem.r(0, 0) = DoubleDouble(1.0);
  return problem;
}

// A double integrator's speed behind a lag of 0.1 ms, a step of 50 ms.
struct StiffSystem {
  SmallMatrix<DoubleDouble, 2, 2> a;
  SmallMatrix<DoubleDouble, 2, 1> b;
  StiffSystem() {
    a(0, 1) = DoubleDouble(1.0);
    a(1, 1) = DoubleDouble(-1e4);
    b(1, 0) = DoubleDouble(1e4);
  }
};
constexpr double kStiffStep = 0.05;

}  // namespace

StabilityFigures product_of_probabilities() {
  planner::RayModelConfig config;
  config.least_visible = 0;
  config.solid = 1;
  const planner::RayModel model(config);
  mapping::OccupancyConfig map_config;
  std::vector<std::int8_t> cells(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(map_config)));
  const mapping::OccupancyMap map(map_config, cells);
  std::fill(cells.begin(), cells.end(), static_cast<std::int8_t>(-mapping::kLogOddsLimit));
  const rt::Vector3 direction{0.6, 0.8, 0};
  const mapping::VoxelWalk walk = mapping::make_walk(map.view(), {1.3, 1.7, 9.5}, direction, 390);
  std::vector<std::uint32_t> codes;
  mapping::VoxelWalk counted = walk;
  do codes.push_back(mapping::cell_code(cells[counted.index]));
  while (counted.step());
  const std::size_t n = codes.size();
  // The published c_i = F_{i-1} - F_n, in double and in twice of it.
  std::vector<double> pass(n + 1, 1.0);
  std::vector<DoubleDouble> wide(n + 1, DoubleDouble(1.0));
  for (std::size_t i = 0; i < n; ++i) {
    const double p = model.probability(codes[i]);
    pass[i + 1] = pass[i] * (1 - p);
    wide[i + 1] = wide[i] * (DoubleDouble(1.0) - DoubleDouble(p));
  }
  double naive = 0;
  DoubleDouble sum;
  for (std::size_t i = 0; i < n; ++i) {
    const double entropy = model.entropy(codes[i]);
    naive += entropy * (pass[i] - pass[n]);
    sum = sum + DoubleDouble(entropy) * (wide[i] - wide[n]);
  }
  const auto truth = static_cast<double>(sum);
  return {std::fabs(model.trace(walk, cells.data()).fresh / truth - 1), std::fabs(naive / truth - 1)};
}

StabilityFigures thousands_of_rays() {
  constexpr int kRays = 4000;
  constexpr double kShare = 0.01;
  std::vector<std::uint16_t> directory(1);
  std::vector<planner::CoverageLine> lines(2);
  std::vector<std::uint32_t> owners(2);
  planner::CoverageTable table({directory, lines, owners});
  double seen = 0;
  for (int i = 0; i < kRays; ++i) {
    table.cover(3, 1 - kShare);
    seen = seen + kShare * (1 - seen);
  }
  const double truth = rt::exp(kRays * rt::log(1 - kShare));
  return {std::fabs(static_cast<double>(table.left(3)) / truth - 1), std::fabs((1 - seen) / truth - 1)};
}

StabilityFigures ties() {
  // 64 of 200 rays have the same worth; entered forward and backward.
  constexpr std::uint32_t kRays = 200;
  const auto worth_of = [](std::uint32_t ray) {
    return ray % 3 == 0 ? 1.0f : 0.25f * static_cast<float>(ray % 5);
  };
  std::vector<std::uint32_t> own[2];
  std::vector<std::uint32_t> naive[2];
  for (int way = 0; way < 2; ++way) {
    std::vector<std::uint64_t> memory(kRays);
    planner::RayHeap heap(memory);
    std::vector<std::pair<float, std::uint32_t>> plain;
    const auto less = [](const auto& a, const auto& b) { return a.first < b.first; };
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const std::uint32_t ray = way == 0 ? i : kRays - 1 - i;
      static_cast<void>(heap.push(planner::RayKey::make(worth_of(ray), ray)));
      plain.emplace_back(worth_of(ray), ray);
      std::push_heap(plain.begin(), plain.end(), less);
    }
    for (std::uint32_t i = 0; i < kRays; ++i) {
      own[way].push_back(planner::RayKey::node(heap.top()));
      heap.pop();
      std::pop_heap(plain.begin(), plain.end(), less);
      naive[way].push_back(plain.back().second);
      plain.pop_back();
    }
  }
  StabilityFigures differ;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    differ.ours += own[0][i] != own[1][i] ? 1 : 0;
    differ.naive += naive[0][i] != naive[1][i] ? 1 : 0;
  }
  return differ;
}

StabilityFigures stiff_riccati() {
  StabilityFigures worst;
  for (const double dt_s : {1e-3, 0.05}) {
    const auto problem = lagged_chain<DoubleDouble>(dt_s, 1e-4, 1e8, 1e-10);
    SmallMatrix<DoubleDouble, 1, 6> k;
    DareReport report;
    const Status status = problem.solve_gain(k, report);
    keep_worst(worst.ours, status == Status::ok ? report.residual : std::nan(""));
    // The same doubling in double, without looking at what it leaves over.
    const auto plain = lagged_chain<double>(dt_s, 1e-4, 1e8, 1e-10);
    SmallMatrix<double, 6, 6> x;
    SmallMatrix<double, 1, 6> plain_k;
    static_cast<void>(plain.doubling(x, report));
    static_cast<void>(plain.gain(x, plain_k));
    SmallMatrix<DoubleDouble, 6, 6> wide_x;
    SmallMatrix<DoubleDouble, 1, 6> wide_k;
    for (std::size_t i = 0; i < 36; ++i) wide_x.m[i] = DoubleDouble(x.m[i]);
    for (std::size_t i = 0; i < 6; ++i) wide_k.m[i] = DoubleDouble(plain_k.m[i]);
    keep_worst(worst.naive, problem.residual(wide_x, wide_k));
  }
  return worst;
}

StabilityFigures unstabilisable() {
  const auto problem = half_reached(1.1, 0.9);
  SmallMatrix<DoubleDouble, 1, 2> k;
  DareReport report;
  const bool given = problem.solve_gain(k, report) == Status::ok;
  // Value iteration, as many steps as a designer waits for: the gain settles, the cost does not.
  double x = 1;
  for (int i = 0; i < 1000; ++i) x = 0.81 * x - 0.81 * x * x / (1 + x) + 1;
  const double second = 0.9 - 0.9 * x / (1 + x);
  return {given ? 1.1 : 0.0, std::max(1.1, std::fabs(second))};
}

StabilityFigures uncontrollable_but_stable() {
  const auto problem = half_reached(0.5, 1.2);
  SmallMatrix<DoubleDouble, 1, 2> k;
  DareReport report;
  if (problem.solve_gain(k, report) != Status::ok) return {std::nan(""), 0};
  // Of the reachable state alone, the equation is x^2 - a^2 x - 1 = 0 for q = r = 1.
  const double x = 0.5 * (1.44 + std::sqrt(1.44 * 1.44 + 4));
  const double truth = 1.2 * x / (1 + x);
  // Ackermann's formula for poles at 0: the last row of [B AB]^-1 times A^2.
  const double reach[2][2] = {{0, 0}, {1, 1.2}};
  const double determinant = reach[0][0] * reach[1][1] - reach[0][1] * reach[1][0];
  const double row[2] = {-reach[1][0] / determinant, reach[0][0] / determinant};
  return {std::fabs(static_cast<double>(k(0, 0))) + std::fabs(static_cast<double>(k(0, 1)) - truth),
          std::fabs(row[0] * 0.25) + std::fabs(row[1] * 1.44)};
}

StabilityFigures stiff_step() {
  const StiffSystem system;
  SmallMatrix<DoubleDouble, 2, 2> ad;
  SmallMatrix<DoubleDouble, 2, 1> bd;
  static_cast<void>(planner::discretise(system.a, system.b, kStiffStep, ad, bd));
  const double truth = rt::exp(-500.0);
  double series = 0;
  double term = 1;
  for (int i = 1; i <= 2000; ++i) {
    series += term;
    term *= -500.0 / i;
  }
  return {std::fabs(static_cast<double>(ad(1, 1)) - truth), std::fabs(series - truth)};
}

StabilityFigures singular_step() {
  const StiffSystem system;
  SmallMatrix<DoubleDouble, 2, 2> ad;
  SmallMatrix<DoubleDouble, 2, 1> bd;
  static_cast<void>(planner::discretise(system.a, system.b, kStiffStep, ad, bd));
  const double truth = kStiffStep - 1e-4 * (1 - rt::exp(-500.0));
  // A^-1 (e^A - 1) B with A = [0 1; 0 -1e4]: Cramer's rule.
  const double determinant = 0.0 * -1e4 - 1.0 * 0.0;
  const double right[2] = {static_cast<double>(ad(0, 1)) * 1e4, (static_cast<double>(ad(1, 1)) - 1) * 1e4};
  const double naive = (right[0] * -1e4 - 1.0 * right[1]) / determinant;
  return {std::fabs(static_cast<double>(bd(0, 0)) - truth), std::fabs(naive - truth)};
}

StabilityFigures straight_line() {
  StabilityFigures worst;
  const planner::IcrModel model;
  constexpr double kDt = 0.1;
  for (const double difference : {0.0, 1e-16, 1e-12, 1e-9}) {
    const planner::TrackSpeeds tracks{0.3, 0.3 + difference};
    const planner::Twist twist = model.to_twist(tracks);
    keep_worst(worst.ours, std::fabs(twist.v_x_m_s * kDt - 0.5 * (tracks.left_m_s + tracks.right_m_s) * kDt));
    // A circle about the common centre.
    const double turn = (tracks.right_m_s - tracks.left_m_s) / 0.4 * kDt;
    const double radius = 0.2 * (tracks.left_m_s + tracks.right_m_s) / (tracks.right_m_s - tracks.left_m_s);
    keep_worst(worst.naive,
               std::fabs(radius * rt::sin(turn) - 0.3 * kDt) + std::fabs(radius * (1 - rt::cos(turn))));
  }
  return worst;
}

StabilityFigures landing_on_target() {
  constexpr double kTarget = 0.503;
  constexpr double kDt = 0.01;
  planner::JerkLimiter limiter;
  double naive = 0;
  StabilityFigures worst;
  for (int i = 0; i < 1000; ++i) {
    limiter.step(kTarget, {1.0, 10.0}, kDt);
    naive += std::copysign(kDt, kTarget - naive);
    if (i < 900) continue;
    keep_worst(worst.ours, std::fabs(limiter.value - kTarget));
    keep_worst(worst.naive, std::fabs(naive - kTarget));
  }
  return worst;
}

StabilityFigures denormal_wish() {
  constexpr double kStep = 0.01;
  const planner::TwistLimits limits;
  const planner::TwistRamps ramps;
  const planner::SpeedTurn wish{0.4, 5e-324};
  planner::TwistLimiter limiter;
  // The turn's ramp made as long as the speed's, by the ratio of the ways alone.
  const double ratio = wish.turn_rad_s / wish.speed_m_s;
  const planner::RampLimits stretched{ramps.speed.acceleration * ratio, ramps.speed.jerk * ratio};
  planner::JerkLimiter speed;
  planner::JerkLimiter turn;
  for (int i = 0; i < 500; ++i) {
    limiter.step(wish, limits, ramps, kStep);
    speed.step(wish.speed_m_s, ramps.speed, kStep);
    turn.step(wish.turn_rad_s, stretched, kStep);
  }
  return {std::fabs(limiter.now().speed_m_s - wish.speed_m_s) + std::fabs(limiter.now().turn_rad_s),
          std::fabs(speed.value - wish.speed_m_s) + std::fabs(turn.value)};
}

}  // namespace sortie::bench
