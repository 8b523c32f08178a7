// SPDX-License-Identifier: BSD-3-Clause
// A simulated mission of rests and drives with a gyro whose bias drifts: what becomes of the heading.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "estimators/attitude.hpp"
#include "tests/estimators/attitude_samples.hpp"

namespace sortie::estimators::test {

/// The gyro: an ADIS16448, its drift times `instability`; and how long the robot stands and drives.
struct StandingMission {
  std::uint32_t seed{};
  double instability{};
  double least_rest_s{1.5}, most_rest_s{20};
  double least_drive_s{20}, most_drive_s{100};
};

/// Errors of the heading, deg.
struct StandingErrors {
  double end{};     ///< at the end of the mission
  double along{};   ///< root of the mean square while driving
  double second{};  ///< most that the heading turned within any second of standing
};

/// Three minutes at 100 Hz, about 20 ms of run time.
class StandingDrive {
 public:
  StandingDrive(const StandingMission& mission, const AttitudeConfig& config)
      : mission_(mission), filter_(config), random_(mission.seed) {
    bias_ = {0.002 * noise(), 0.002 * noise(), 0.002 * noise()};
  }

  StandingErrors run() {
    stretch(2.0 + between(mission_.least_rest_s, mission_.most_rest_s), false);
    while (t_s_ < 180.0) {
      stretch(between(mission_.least_drive_s, mission_.most_drive_s), true);
      stretch(between(mission_.least_rest_s, mission_.most_rest_s), false);
    }
    stretch(5.0, true);  // what the last rest has taught
    errors_.end = std::fabs(error_deg());
    errors_.along = std::sqrt(square_ / driven_);
    return errors_;
  }

 private:
  static constexpr double kStep_s = 0.01;

  double noise() {
    double sum = -2;
    for (int i = 0; i < 4; ++i) sum += static_cast<double>(random_() % 65536u) / 65536.0;
    return 1.732 * sum;
  }
  Vector3 three(double sigma) {
    const double x = noise(), y = noise(), z = noise();
    return sigma * Vector3{x, y, z};
  }
  double between(double least, double most) {
    return least + (most - least) * static_cast<double>(random_() % 65536u) / 65536.0;
  }
  double error_deg() const {
    const Quaternion error = attitude_of(filter_) * conjugate(truth_);
    return kDegrees * rt::wrap_angle(2 * std::atan2(error.z, error.w));
  }

  void stretch(double lasts_s, bool moving) {
    const double begin_s = t_s_;
    double turn = 0;
    double wish = 0;
    std::array<double, 100> past{};
    std::uint64_t stood = 0;
    for (int i = 0; t_s_ < begin_s + lasts_s; ++i) {
      t_s_ += kStep_s;
      if (i % 300 == 0) wish = between(-0.8, 0.8);
      const double ease = std::min({1.0, 2 * (t_s_ - begin_s), 2 * std::max(0.0, begin_s + lasts_s - t_s_)});
      turn += 2 * kStep_s * (wish - turn);
      const Vector3 rate =
          moving ? ease * Vector3{0.3 * std::cos(7 * t_s_), 0.3 * std::cos(5 * t_s_), turn} : Vector3{};
      truth_ = normalised(truth_ * exp_rotation(kStep_s * rate));
      bias_ = bias_ + three(mission_.instability * 1e-5 * std::sqrt(kStep_s));
      const Vector3 gyr = rate + bias_ + three(3.4e-4 / std::sqrt(kStep_s));
      const Vector3 acc = rotate_back(truth_, kGravity) + three(moving ? 1.2 * ease + 0.04 : 0.04);
      now_ += 10 * kMs;
      filter_.set_moving(moving);
      static_cast<void>(filter_.update(sample_of(now_, gyr, acc, kBoth | rt::kImuMeanRate)));
      const double error = error_deg();
      if (moving) {
        square_ += error * error;
        driven_ += 1;
        continue;
      }
      double& second_ago = past[static_cast<std::size_t>(stood % past.size())];
      if (stood++ >= past.size())
        errors_.second =
            std::max(errors_.second, kDegrees * std::fabs(rt::wrap_angle((error - second_ago) / kDegrees)));
      second_ago = error;
    }
  }

  StandingMission mission_;
  Attitude filter_;
  std::mt19937 random_;
  Quaternion truth_;
  Vector3 bias_;
  rt::Nanoseconds now_{};
  double t_s_{};
  double square_{};
  double driven_{};
  StandingErrors errors_;
};

}  // namespace sortie::estimators::test
