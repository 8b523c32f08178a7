// SPDX-License-Identifier: BSD-3-Clause
// A long time of one sensor in float and in double, with the same samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "estimators/attitude.hpp"
#include "tests/estimators/attitude_samples.hpp"

namespace sortie::estimators::test {

/// Worst and last errors of a run.
struct DayErrors {
  double inclination_deg[2]{};  ///< double, float: worst after five minutes, in which the bias is learned
  double heading_deg[2]{};      ///< at the end
  double length[2]{};           ///< worst | |q| - 1 |
  double apart_deg{};           ///< between both, at worst
};

/// `hours` at 100 Hz with bias and noise; `moving`: nods and turns all the while, else stands still.
inline DayErrors run_day(double hours, bool moving) {
  AttitudeConfig config;
  BasicAttitude<double> wide{config};
  BasicAttitude<float> narrow{config};
  std::mt19937 random(11);
  const auto noise = [&random] {
    double sum = -2;
    for (int i = 0; i < 4; ++i) sum += static_cast<double>(random() % 65536u) / 65536.0;
    return 1.732 * sum;
  };
  const Vector3 bias{0.004, -0.003, 0.002};
  Quaternion truth;
  DayErrors worst;
  const auto steps = static_cast<std::int64_t>(hours * 360'000);
  for (std::int64_t i = 1; i <= steps; ++i) {
    const double t = 0.01 * static_cast<double>(i % 6'283'185);
    const Vector3 rate =
        moving ? Vector3{0.3 * std::sin(0.7 * t), 0.2 * std::sin(1.1 * t), 0.5 * std::sin(0.4 * t)}
               : Vector3{};
    truth = normalised(truth * exp_rotation(0.01 * rate));
    const double a = noise(), b = noise(), c = noise(), d = noise(), e = noise(), f = noise();
    const rt::ImuSample sample =
        sample_of(i * 10 * kMs, rate + bias + 0.001 * Vector3{a, b, c},
                  rotate_back(truth, kGravity) + 0.02 * Vector3{d, e, f}, kBoth | rt::kImuMeanRate);
    static_cast<void>(wide.update(sample));
    static_cast<void>(narrow.update(sample));
    if (i % 100 != 0) continue;
    const Quaternion q[2] = {rt::to_quaternion(wide.estimate().q_world_body),
                             rt::to_quaternion(narrow.estimate().q_world_body)};
    for (int k = 0; k < 2; ++k) {
      worst.length[k] = std::max(worst.length[k], std::fabs(std::sqrt(squared_norm(q[k])) - 1));
      if (i > 30'000)
        worst.inclination_deg[k] =
            std::max(worst.inclination_deg[k], kDegrees * inclination_error(q[k], truth));
      const Quaternion error = q[k] * conjugate(truth);
      worst.heading_deg[k] = kDegrees * rt::wrap_angle(2 * std::atan2(error.z, error.w));
    }
    worst.apart_deg = std::max(worst.apart_deg, kDegrees * angle_between(q[0], normalised(q[1])));
  }
  return worst;
}

}  // namespace sortie::estimators::test
