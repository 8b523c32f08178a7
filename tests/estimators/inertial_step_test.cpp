// SPDX-License-Identifier: BSD-3-Clause
// The flight estimator's covariance goes where differences of its states go.
#include "estimators/uav_state/inertial_step.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace {
using namespace sortie;
using namespace sortie::estimators;
using Errors = std::array<double, kErrorStates>;

rt::Vector3 part(const Errors& e, std::size_t group) {
  return {e[3 * group], e[3 * group + 1], e[3 * group + 2]};
}

InertialState moved_by(const InertialState& s, const Errors& e) {
  return {s.p_world_m + part(e, 0), s.v_world_m_s + part(e, 1), s.q_world_body * rt::exp_rotation(part(e, 2)),
          s.gyr_bias_rad_s + part(e, 3), s.acc_bias_m_s2 + part(e, 4)};
}

Errors between(const InertialState& from, const InertialState& to) {
  const rt::Vector3 parts[5] = {to.p_world_m - from.p_world_m, to.v_world_m_s - from.v_world_m_s,
                                rt::log_rotation(rt::conjugate(from.q_world_body) * to.q_world_body),
                                to.gyr_bias_rad_s - from.gyr_bias_rad_s,
                                to.acc_bias_m_s2 - from.acc_bias_m_s2};
  Errors e{};
  for (std::size_t i = 0; i < 5; ++i) {
    e[3 * i] = parts[i].x;
    e[3 * i + 1] = parts[i].y;
    e[3 * i + 2] = parts[i].z;
  }
  return e;
}

Errors times(double factor, Errors e) {
  for (double& value : e) value *= factor;
  return e;
}
}  // namespace

TEST_CASE("The covariance of an inertial step is that of states that differ and are moved alike") {
  constexpr unsigned kSeed = 17;
  INFO("seed " << kSeed);
  std::mt19937 random(kSeed);
  const auto uniform = [&random](double most) {
    return most * (static_cast<double>(random()) / 2147483648.0 - 1);
  };
  const auto vector = [&uniform](double most) {
    return rt::Vector3{uniform(most), uniform(most), uniform(most)};
  };
  // So that each part of an error counts in the next step. What a bias of the gyro makes of the force within
  // the step itself (0.5 %) is left out by the filter.
  constexpr double kSize[5] = {3e-4, 0.05, 0.1, 2.0, 10.0};
  for (int round = 0; round < 200; ++round) {
    InertialState s{vector(10), vector(3), rt::normalised(rt::exp_rotation(vector(2))), vector(0.02),
                    vector(0.1)};
    const InertialReading reading{0.005, vector(0.3), vector(10)};
    Errors error{};
    for (std::size_t i = 0; i < kErrorStates; ++i) error[i] = uniform(kSize[i / 3]);

    InertialState here = s;
    InertialState more = moved_by(s, times(1e-5, error));
    InertialState less = moved_by(s, times(-1e-5, error));
    static_cast<void>(predict(here, reading, 9.81));
    static_cast<void>(predict(more, reading, 9.81));
    static_cast<void>(predict(less, reading, 9.81));
    const Errors up = between(here, more);
    const Errors down = between(here, less);
    Errors expected{};
    for (std::size_t i = 0; i < kErrorStates; ++i) expected[i] = 0.5e5 * (up[i] - down[i]);

    ErrorCovariance p;
    for (std::size_t i = 0; i < kErrorStates; ++i) {
      for (std::size_t j = 0; j < kErrorStates; ++j) p(i, j) = error[i] * error[j];
    }
    propagate(p, s, reading, {0, 0, 0, 0});
    for (std::size_t i = 0; i < kErrorStates; ++i) {
      for (std::size_t j = 0; j < kErrorStates; ++j) {
        CAPTURE(round, i, j);
        const double size = (kSize[i / 3] + rt::norm(part(expected, i / 3))) *
                            (kSize[j / 3] + rt::norm(part(expected, j / 3)));
        REQUIRE(std::fabs(p(i, j) - expected[i] * expected[j]) <= 0.02 * size);
      }
    }
  }
}

TEST_CASE("The noise of an inertial step adds up to its densities over a second") {
  const InertialNoise noise;
  ErrorCovariance p;
  for (int i = 0; i < 200; ++i) propagate(p, {}, {0.005, {}, {}}, noise);
  const double expected[5] = {noise.acc_m_s2_rt_hz / std::sqrt(3.0), noise.acc_m_s2_rt_hz,
                              noise.gyr_rad_s_rt_hz, noise.gyr_walk_rad_s_rt_s, noise.acc_walk_m_s2_rt_s};
  for (std::size_t i = 0; i < kErrorStates; ++i) {
    CAPTURE(i);
    CHECK(std::sqrt(p(i, i)) == Approx(expected[i / 3]).epsilon(0.02));
  }
}
