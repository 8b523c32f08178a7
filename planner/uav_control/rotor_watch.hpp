// SPDX-License-Identifier: BSD-3-Clause
// Compares how the vehicle turns with how its rotors should turn it: steady loads are told to the controller,
// a lost rotor by its number.
#pragma once

#include <cstdint>

#include "planner/uav_control/uav_model.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// Differences of angular acceleration, filtered. A lost rotor leaves its own torque about roll and pitch
/// missing, and these point in different directions for all rotors. 300 bytes, no heap.
class RotorWatch {
 public:
  static constexpr std::uint32_t kNone = rt::kMaxRotors;

  RotorWatch(const UavModel& model, double period_s);

  /// Anew; also after a rotor was dropped: what was learned included its absence.
  void reset();
  /// One period: turn rate at its end, mean thrusts that the rotors were to have, the torque that they make
  /// together. Gives the number of a rotor that must be lost, once, or kNone.
  std::uint32_t update(const rt::Vector3& w_body_rad_s, const double* mean_n, const rt::Vector3& torque_n_m);

  /// Angular acceleration that the rotors do not explain, slowly: loads off the centre.
  const rt::Vector3& load_rad_s2() const { return slow_; }

  /// State to bytes and back, into one of the same vehicle.
  void archive(rt::Archive& archive);

 private:
  UavModel model_;
  double dt_;
  double keep_fast_;
  double keep_slow_;
  double keep_base_;
  double least_n_;        ///< thrust below which a rotor's loss cannot be told
  double least_torque2_;  ///< square of the least torque that any loss can leave
  bool started_{};
  rt::Vector3 last_w_;
  rt::Vector3 fast_;
  rt::Vector3 slow_;
  rt::Vector3 base_;
  double fast_n_[rt::kMaxRotors]{};
  double held_s_{};
  std::uint32_t suspect_{kNone};
};

}  // namespace sortie::planner
