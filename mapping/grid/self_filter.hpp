// SPDX-License-Identifier: BSD-3-Clause
// Which points of a lidar lie on the robot itself: its fixed parts and its moving flippers.
#pragma once

#include <cstdint>

#include "rt/keys.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// A box that moves with the body, along the body's axes.
struct BodyBox {
  rt::Vector3 centre_m;
  rt::Vector3 half_m;
};

/// The four flippers: two wheels each, joined by their common tangents. They turn about the body's y axis.
struct FlipperOutline {
  rt::Vector3 pivot_m;  ///< of the front left one, on the axle of its large wheel; the others mirror it
  double length_m{};    ///< from axle to axle; 0: the robot has no flippers
  double large_radius_m{};
  double small_radius_m{};
  double half_width_m{};

  SORTIE_KEYS(c, key) {
    key("flipper_length_m", c.length_m, {0, 10, "m", "from axle to axle; 0: the filter knows no flippers"});
    if (c.length_m == 0.0) return;
    key("flipper_pivot_m", c.pivot_m,
        {-10, 10, "m", "large axle of the front left flipper, body frame; the others mirror it"});
    key("flipper_large_radius_m", c.large_radius_m, {0, 10, "m", "of the wheel at the pivot"});
    key("flipper_small_radius_m", c.small_radius_m, {0, 10, "m", "of the wheel at the tip"});
    key("flipper_half_width_m", c.half_width_m, {0, 10, "m", "of a flipper"});
  }
};

/// The robot's outline, body frame.
struct SelfFilterConfig {
  static constexpr std::uint32_t kMaxBoxes = 4;
  BodyBox boxes[kMaxBoxes]{};
  std::uint32_t box_count{};
  FlipperOutline flippers{};
  double margin_m{0.03};  ///< as far from the outline a point still counts as the robot
  double shadow_m{0.0};   ///< a ray that passes the outline as near as this may have met its edge; 0: none
};

/// Tells the robot from the world. No heap. Flipper angles: front and rear ones positive when they point up,
/// in the order front left, front right, rear left, rear right.
class SelfFilter {
 public:
  /// With a config that is not usable, usable() says why not, and nothing counts as the robot.
  explicit SelfFilter(const SelfFilterConfig& config);

  /// ok; out_of_range: a size is negative or not finite, there are too many boxes, or a wheel holds the
  /// other.
  Status usable() const { return usable_; }

  /// Flippers from now on. Angles that are not finite are refused (not_finite), and the last good ones stay.
  Status set_flippers(const double (&angle_rad)[rt::kFlippers]);

  /// True within the margin of the outline. `p_body_m` must be finite. Cost: a sphere first, then 4 boxes
  /// and 4 flippers: 2 ns for a far point, 30 ns on the robot.
  bool is_robot(const rt::Vector3& p_body_m) const;

  /// True for a point whose ray from `sensor_body_m` passes within shadow_m of the outline: part of its beam
  /// may have met the robot, and then the range is of neither. Points are finite. Cost: up to 40 looks at the
  /// outline, 0.5 us; none without shadow_m.
  bool is_shadowed(const rt::Vector3& sensor_body_m, const rt::Vector3& p_body_m) const;

 private:
  bool is_within(const rt::Vector3& p_body_m, double margin_m) const;
  bool on_flipper(std::uint32_t flipper, const rt::Vector3& p_body_m, double margin_m) const;

  SelfFilterConfig config_;
  Status usable_{Status::ok};
  double reach2_m2_{};  ///< squared distance from the body's origin beyond which nothing of the robot is
  double reach_m_{};    ///< the same, not squared, with shadow_m for the margin
  double taper_sin_{};  ///< of the angle between the flipper's middle line and its edges
  double taper_cos_{1};
  double along_x_[rt::kFlippers]{};  ///< unit vectors from pivot to small wheel
  double along_z_[rt::kFlippers]{};
};

}  // namespace sortie::mapping
