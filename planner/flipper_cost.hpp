// SPDX-License-Identifier: BSD-3-Clause
// What a choice of flippers costs along the places ahead, and whether it is safe there.
#pragma once

#include <algorithm>
#include <cmath>

#include "planner/posture.hpp"

namespace sortie::planner {

/// Prices. All at least 0, so that a sum over some of the places is never above the sum over all.
struct FlipperWeights {
  double jump{2.0};       ///< per rad of the largest change of pitch from a place to the next
  double swing{1.0};      ///< per rad of all changes together
  double pitch{0.3};      ///< per rad of the worst pitch
  double roll{0.6};       ///< per rad of the worst roll
  double clearance{3.0};  ///< per m of belly clearance below `wanted_clearance_m`
  double margin{2.0};     ///< per m of stability margin below `wanted_margin_m`
  double face{0.5};       ///< a far place where a face stops the nose: the flippers must change on the way
  double time{0.05};      ///< per s until the flippers are there
  double change{0.05};    ///< per rad of mean change of what was asked before
  double wanted_clearance_m{0.04};
  double wanted_margin_m{0.10};
};

/// What a vehicle must keep to at every place.
struct FlipperLimits {
  double margin_m{0.03};    ///< at least
  double clearance_m{0.0};  ///< at least; a belly that touches has 0, which is not below
  double tilt_rad{0.75};    ///< of pitch and of roll, at most
  double jump_rad{0.5};     ///< of pitch and of roll from a place to the next, at most: more is a fall
  /// Of an outline that meets a face: what belts climb.
  double climb_rad{1.134};
};

/// One choice of flippers on one ground, place by place.
struct FlipperWalk {
  PostureSolver::Start tilt;  ///< where the next place's rest starts from
  bool safe{true};            ///< of every place so far
  bool near_safe{true};       ///< of the first two
  double jump_rad{}, swing_rad{}, pitch_rad{}, roll_rad{};
  double clearance_m{1.0};  ///< least
  double margin_m{1.0};     ///< least
  int places{};
  int unsafe{};  ///< places
  int faces{};   ///< that stop it

  /// Takes the next place. A vehicle that tips, or of which nothing is known, is not safe; nor is one that a
  /// face stops at the first two.
  void add(const Posture& p, bool blocked, const FlipperLimits& limits) {
    const bool stands = p.rest == Rest::stands;
    const double change = std::fabs(p.pitch_rad - tilt.pitch_rad);
    if (blocked) ++faces;
    if (!stands || (blocked && places < 2) || p.margin_m < limits.margin_m ||
        p.clearance_m < limits.clearance_m ||
        std::max(std::fabs(p.pitch_rad), std::fabs(p.roll_rad)) > limits.tilt_rad ||
        std::max(change, std::fabs(p.roll_rad - tilt.roll_rad)) > limits.jump_rad) {
      safe = false;
      ++unsafe;
      if (places < 2) near_safe = false;
    }
    ++places;
    if (!stands) {
      margin_m = 0.0;
      return;
    }
    jump_rad = std::max(jump_rad, change);
    swing_rad += change;
    pitch_rad = std::max(pitch_rad, std::fabs(p.pitch_rad));
    roll_rad = std::max(roll_rad, std::fabs(p.roll_rad));
    clearance_m = std::min(clearance_m, p.clearance_m);
    margin_m = std::min(margin_m, p.margin_m);
    tilt = {p.pitch_rad, p.roll_rad};
  }

  /// Never falls as places are added.
  double cost(const FlipperWeights& w) const {
    return w.jump * jump_rad + w.face * faces + w.swing * swing_rad + w.pitch * pitch_rad +
           w.roll * roll_rad + w.clearance * std::max(0.0, w.wanted_clearance_m - clearance_m) +
           w.margin * std::max(0.0, w.wanted_margin_m - margin_m);
  }
};

}  // namespace sortie::planner
