// SPDX-License-Identifier: BSD-3-Clause
// Belt speeds over time, ramped gently enough that tracks do not slip, and where they lead in theory.
#pragma once

#include "tests/bench/plant/bench_scene.hpp"

namespace sortie::bench {

/// Mean speeds of the belts in a step.
struct BeltSpeeds {
  double left_m_s{};
  double right_m_s{};
};

/// The command of a scene. Speeds rise and fall at 0.25 mu g of the faster belt.
class DrivePlan {
 public:
  explicit DrivePlan(const BenchScene& scene);

  /// Mean command over a step that begins at `t_s`, counted from the end of settling.
  BeltSpeeds belts(double t_s, double dt_s) const;

  /// The same without friction's limits and without obstacles: where a vehicle that started at `start` and
  /// moves as the belts ask is at `t_s`, in closed form (arcs of the pulses, one after the other).
  BenchPose closed_form(const BenchPose& start, double t_s) const;

  static constexpr double kHalfSpan_m = 0.1985;  ///< from the middle to a track's turning centre

 private:
  /// Time at full speed that counts until `t_s`: the ramps' integral.
  double held_s(const Pulse& pulse, double t_s) const;

  std::vector<Pulse> pulses_;
  double acceleration_m_s2_;
};

}  // namespace sortie::bench
