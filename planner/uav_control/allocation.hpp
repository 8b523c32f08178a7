// SPDX-License-Identifier: BSD-3-Clause
// From wanted thrust and torques to the thrust of each rotor, within what rotors can do.
#pragma once

#include <cstdint>

#include "planner/uav_control/uav_model.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// Collective thrust and torques about the body's axes.
struct RotorWrench {
  double thrust_n{};
  rt::Vector3 torque_n_m;
  SORTIE_FIELDS(thrust_n, torque_n_m)
};

/// Thrust of each rotor, N.
struct RotorThrusts {
  double force_n[rt::kMaxRotors]{};
  bool limited{};  ///< the wrench could not be met
};

/// Shares a wrench out to the rotors. While it fits, the smallest sum of squares (the pseudo-inverse). Where
/// it does not, or a rotor is lost, the nearest wrench that fits, with errors of roll and pitch torque
/// weighing far more than those of thrust, and these far more than yaw: a bounded least-squares problem,
/// solved by an active set of at most 3 changes a rotor. No heap; 4 products a rotor as a rule, at most 24
/// eliminations of 8 unknowns.
class Allocation {
 public:
  explicit Allocation(const UavModel& model);

  /// Never non-finite for a finite wrench.
  RotorThrusts share(const RotorWrench& wanted) const;

  /// The rotor makes nothing from now on. The last four are kept: false.
  bool lose(std::uint32_t rotor);
  bool lost(std::uint32_t rotor) const { return lost_[rotor]; }
  std::uint32_t lost_count() const { return lost_count_; }

  /// What these thrusts make together.
  RotorWrench wrench(const double* force_n) const;

  /// State to bytes and back, into one of the same vehicle.
  void archive(rt::Archive& archive);

 private:
  RotorThrusts bounded(const double (&wanted)[4]) const;
  void free_solution(const bool* fixed, const double* at, const double (&wanted)[4], double* out) const;

  UavModel model_;
  double effect_[4][rt::kMaxRotors]{};  ///< thrust, roll, pitch, yaw of one newton
  double inverse_[rt::kMaxRotors][4]{};
  double weighted_[4][rt::kMaxRotors]{};  ///< effects times the weights of the bounded problem
  double weight_[4]{};
  double most_n_{};
  bool lost_[rt::kMaxRotors]{};
  std::uint32_t lost_count_{};
};

}  // namespace sortie::planner
