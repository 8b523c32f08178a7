// SPDX-License-Identifier: BSD-3-Clause
// How much of the turn that its tracks ask for a skid-steered robot makes: learned from the gyro.
#pragma once

#include <cmath>

#include "rt/archive.hpp"
#include "rt/describe.hpp"

namespace sortie::estimators {

/// Settings of the steering efficiency.
struct SteeringConfig {
  double track_width_m{};     ///< between the middles of the tracks; 0 switches the estimate off
  double first{0.7};          ///< before anything is known
  double first_rad2_s{0.05};  ///< what that counts as: half a second at 0.3 rad/s
  double least_rad_s{0.1};    ///< of the gyro: slower turns teach nothing
  double keeps_s{30.0};       ///< time of turning after which what was learned counts 1/e
  double doubted{0.2};        ///< tracks with less are no measure of a turn: nothing is judged by them
  SORTIE_FIELDS(track_width_m, first, first_rad2_s, least_rad_s, keeps_s, doubted)
};

/// Share chi = B / (y_left - y_right) of the ICR model (Martinez et al. 2005): turn = chi (right - left) / B.
/// Recursive least squares with forgetting. The heading itself never comes from the tracks; chi tells what
/// they should have done, so that slip can be seen, and how far apart their turning centres are. 80 bytes.
class SteeringEfficiency {
 public:
  explicit SteeringEfficiency(const SteeringConfig& config)
      : config_(config), together_(config.first * config.first_rad2_s), squared_(config.first_rad2_s) {}

  /// Takes a step: travel of both tracks and the gyro's turn about the body's up axis. Finite, dt above 0.
  void update(double dt_s, double left_m, double right_m, double turn_rad) {
    if (config_.track_width_m <= 0.0 || std::fabs(turn_rad) < config_.least_rad_s * dt_s) return;
    const double asked_rad = (right_m - left_m) / config_.track_width_m;
    const double keep = config_.keeps_s / (config_.keeps_s + dt_s);
    together_ = keep * together_ + asked_rad * turn_rad / dt_s;
    squared_ = keep * squared_ + asked_rad * asked_rad / dt_s;
  }

  /// chi; what was configured until a turn was seen.
  double value() const { return squared_ > 1e-12 ? together_ / squared_ : config_.first; }
  /// False where the tracks claim so much more than the gyro that they say nothing about a turn.
  bool trusted() const { return value() > config_.doubted; }
  /// Turn that these travels make, rad.
  double expected_rad(double left_m, double right_m) const {
    return config_.track_width_m > 0.0 ? value() * (right_m - left_m) / config_.track_width_m : 0.0;
  }
  /// Distance of the tracks' turning centres, y_left - y_right, m.
  double centres_apart_m() const { return value() > 1e-6 ? config_.track_width_m / value() : 0.0; }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "steering efficiency").fixed(config_).state(together_, squared_);
  }

 private:
  SteeringConfig config_;
  double together_;
  double squared_;
};

}  // namespace sortie::estimators
