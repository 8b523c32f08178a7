// SPDX-License-Identifier: BSD-3-Clause
// Today's modes as missions use them: postures by name, changed at a time that the mission's author chose.
#pragma once

#include "hil/plant/course_drivers.hpp"
#include "planner/flipper_postures.hpp"

namespace sortie::bench {

/// `climb` until the author takes the vehicle to be over the obstacle, then `flat`, both as ugv_pallet has
/// them; `flat` alone where the way leads down. planner::FlipperPostures goes from one to the other.
class MissionDriver : public hil::FlipperDriver {
 public:
  void begin(const hil::Course& course) override;
  hil::DriverOrder drive(const hil::DriverView& view) override;

 private:
  hil::LineKeeper line_;
  planner::FlipperPostures postures_;
  double flat_s_{};  ///< when it is told to lie flat
};

}  // namespace sortie::bench
