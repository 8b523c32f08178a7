// SPDX-License-Identifier: BSD-3-Clause
// Contact surface motion without its singular cases, and plain belts.
#include "hil/plant/surface_motion.hpp"

#include <algorithm>

namespace sortie::hil {
namespace {

constexpr double kSideOfTrack = 0.1;  ///< |y x n| below which the drive fades: 6 degrees from the axis

}  // namespace

BeltMotion belt_motion(double left_m_s, double right_m_s, double dt_s, const VehicleConfig& config) {
  const double span = config.icr_left_m - config.icr_right_m;
  BeltMotion motion;
  motion.left_m_s = left_m_s;
  motion.right_m_s = right_m_s;
  motion.turn_rad_s = config.steering_efficiency * (right_m_s - left_m_s) / span;
  motion.forward_m_s = (config.icr_left_m * right_m_s - config.icr_right_m * left_m_s) / span;
  motion.sideways_m_s = 0.5 * dt_s * motion.turn_rad_s * motion.forward_m_s;
  return motion;
}

Vec3 surface_target(const Vec3& point_m, const Vec3& normal, int side, const BeltMotion& belts,
                    const VehicleConfig& config) {
  const Vec3 along{normal.z, 0.0, -normal.x};  // y x n
  const double length = norm(along);
  const double share = std::min(1.0, length / kSideOfTrack);
  const Vec3 forward = (1.0 / std::max(length, kSideOfTrack)) * along;  // a unit vector, but for the fade
  if (config.mode == ContactMode::still) return {};
  if (config.mode == ContactMode::belt) return (side > 0 ? belts.left_m_s : belts.right_m_s) * forward;
  const Vec3 arm{point_m.x - config.icr_x_m, point_m.y, point_m.z};
  const Vec3 left = Vec3{0.0, 1.0, 0.0} - normal.y * normal;
  return belts.forward_m_s * forward + (share * belts.turn_rad_s) * cross(normal, arm) +
         (share * belts.sideways_m_s) * left;
}

}  // namespace sortie::hil
