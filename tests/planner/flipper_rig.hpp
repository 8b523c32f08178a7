// SPDX-License-Identifier: BSD-3-Clause
// Ground read once into cells, some of them masked or mirrored, and a policy that is asked on it.
#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "hil/random.hpp"
#include "planner/flipper_policy.hpp"
#include "tests/planner/posture_courses.hpp"

namespace sortie::planner {

/// 20 m by 20 m of cells of 5 cm around the origin; unknown beyond.
struct CellGround {
  static constexpr int kHalf = 200;
  std::vector<HeightCell> cells = std::vector<HeightCell>(4 * kHalf * kHalf);
  bool mirrored{};  ///< left and right of the world's x axis change places

  static std::size_t index(std::int64_t i, std::int64_t j) {
    return static_cast<std::size_t>((j + kHalf) * 2 * kHalf + i + kHalf);
  }
  HeightCell& at(std::int64_t i, std::int64_t j) { return cells[index(i, j)]; }

  /// From heights, by 4 x 4 places a cell, within `half` cells of the origin.
  template <class Height>
  static CellGround of(Height height, int half = 60) {
    CellGround ground;
    for (int j = -half; j < half; ++j) {
      for (int i = -half; i < half; ++i) {
        HeightCell cell{1e9, -1e9, HeightState::known};
        for (int k = 0; k < 16; ++k) {
          const double h = height((i + 0.125 + 0.25 * (k % 4)) * 0.05, (j + 0.125 + 0.25 * (k / 4)) * 0.05);
          cell.low_m = std::min(cell.low_m, h);
          cell.high_m = std::max(cell.high_m, h);
        }
        ground.at(i, j) = cell;
      }
    }
    return ground;
  }
  static CellGround of(const BoxCourse& course) {
    return of([&course](double x, double y) { return course.height(x, y); });
  }

  /// Forgets about `share` of the cells, in patches of `patch` by `patch` cells.
  void mask(double share, int patch, hil::Random& random) {
    const auto side = 2 * kHalf / patch;
    for (int v = 0; v < side; ++v)
      for (int u = 0; u < side; ++u) {
        if (random.uniform(0.0, 1.0) >= share) continue;
        for (int k = 0; k < patch * patch; ++k)
          at(u * patch - kHalf + k % patch, v * patch - kHalf + k / patch) = {};
      }
  }

  static HeightCell cell(const void* ground, std::int64_t i, std::int64_t j) {
    const auto& self = *static_cast<const CellGround*>(ground);
    if (self.mirrored) j = -1 - j;
    if (i < -kHalf || j < -kHalf || i >= kHalf || j >= kHalf) return {};
    return self.cells[index(i, j)];
  }
  HeightView view() const { return {this, &CellGround::cell, 0.05}; }
};

inline std::unique_ptr<FlipperPolicy> flipper_policy(const FlipperPolicyConfig& config = {}) {
  auto policy = std::make_unique<FlipperPolicy>(posture_vehicle({}), config);
  if (policy->usable() != Status::ok) throw std::runtime_error("flippers: a policy that cannot be used");
  return policy;
}

/// An input at `stamp_ns` whose parts are all fresh: at a place, level, flippers at 0.5.
inline FlipperInput flipper_input(rt::Nanoseconds stamp_ns, const StandPose& pose, double z_m) {
  FlipperInput in;
  in.stamp_ns = in.map_ns = in.attitude_ns = in.flippers_ns = stamp_ns;
  in.pose = pose;
  in.z_m = z_m;
  for (int f = 0; f < 4; ++f) {
    in.measured_rad[f] = 0.5;
    in.mission_rad[f] = 0.7;
  }
  in.arc = {0.2, 0.0};
  return in;
}

/// Puts pitch, roll and height into an input as the ground would have the vehicle stand; false where it would
/// not.
inline bool settle(const HeightView& view, FlipperInput& in) {
  const auto solver = std::make_unique<PostureSolver>(posture_vehicle({}), PostureConfig{});
  Posture p;
  FlipperSet angles;
  for (int f = 0; f < 4; ++f) angles.angle_rad[f] = in.measured_rad[f];
  if (solver->look(view, in.pose) != Status::ok || solver->rest(angles, p) != Status::ok) return false;
  in.pitch_rad = p.pitch_rad;
  in.roll_rad = p.roll_rad;
  in.z_m = p.height_m;
  return p.rest == Rest::stands;
}

inline bool moves(const FlipperDecision& d) { return d.share > 0.0; }

}  // namespace sortie::planner
