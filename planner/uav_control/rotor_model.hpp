// SPDX-License-Identifier: BSD-3-Clause
// Where the rotors' speeds are by now: the controller's own idea of them.
#pragma once

#include "planner/uav_control/uav_model.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// First-order lags driven by the commands, exact over a period. No heap; 3 operations a rotor.
class RotorModel {
 public:
  RotorModel(const UavModel& model, double period_s)
      : model_(model),
        keep_up_(rt::exp(-period_s / model.tau_up_s)),
        keep_down_(rt::exp(-period_s / model.tau_down_s)) {}

  /// All rotors at the speed that carries `share` of the weight.
  void reset(double share) {
    const double thrust = share * model_.mass_kg * model_.gravity_m_s2 / static_cast<double>(model_.rotors);
    for (double& speed : speed_) speed = std::sqrt(thrust / model_.thrust_n_s2);
    update_thrust();
    for (std::uint32_t i = 0; i < model_.rotors; ++i) mean_n_[i] = thrust_n_[i];
  }

  /// One period with these commands.
  void step(const double* command_rad_s) {
    double before[rt::kMaxRotors];
    for (std::uint32_t i = 0; i < model_.rotors; ++i) {
      before[i] = thrust_n_[i];
      const double keep = command_rad_s[i] > speed_[i] ? keep_up_ : keep_down_;
      speed_[i] = command_rad_s[i] + keep * (speed_[i] - command_rad_s[i]);
    }
    update_thrust();
    for (std::uint32_t i = 0; i < model_.rotors; ++i) mean_n_[i] = 0.5 * (before[i] + thrust_n_[i]);
  }

  /// Thrusts now, N.
  const double* thrust_n() const { return thrust_n_; }
  /// Their means over the last period.
  const double* mean_n() const { return mean_n_; }

  /// State to bytes and back, into one of the same vehicle.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "rotor model")
        .fixed(model_, keep_up_, keep_down_)
        .state(speed_, thrust_n_, mean_n_);
  }

 private:
  void update_thrust() {
    for (std::uint32_t i = 0; i < model_.rotors; ++i)
      thrust_n_[i] = model_.thrust_n_s2 * speed_[i] * speed_[i];
  }

  UavModel model_;
  double keep_up_;
  double keep_down_;
  double speed_[rt::kMaxRotors]{};
  double thrust_n_[rt::kMaxRotors]{};
  double mean_n_[rt::kMaxRotors]{};
};

}  // namespace sortie::planner
