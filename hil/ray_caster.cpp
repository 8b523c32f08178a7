// SPDX-License-Identifier: BSD-3-Clause
#include "hil/ray_caster.hpp"

#include <cmath>

namespace sortie::hil {
namespace {

// A rotation, up to rounding. blend() would make an identity of what is none.
bool rotates(const Quat& q) { return dot(q, q) > 0.99 && dot(q, q) < 1.01; }

bool usable(const Motion& motion) { return is_finite(motion.p_world_body_m) && rotates(motion.q_world_body); }

RangeHit to_range(const Hit& hit, const Vec3& direction) {
  return {hit.range_m, std::fabs(dot(hit.normal, direction)), hit.solid, hit.reflectivity, hit.normal};
}

RangeHit to_range(const ShellHit& hit, const Vec3& direction) {
  return {hit.range_m, std::fabs(dot(hit.normal, direction)), RangeHit::kOwnBody - hit.part,
          RayCaster::kShellReflectivity, hit.normal};
}

}  // namespace

Status body_at(const SensorStep& step, rt::Nanoseconds stamp_ns, BodyInstant& body) {
  if (!usable(step.before) || !usable(step.after)) return Status::not_finite;
  const rt::Nanoseconds span = step.after.stamp_ns - step.before.stamp_ns;
  const double share =
      span > 0 ? static_cast<double>(stamp_ns - step.before.stamp_ns) / static_cast<double>(span) : 1.0;
  BodyInstant at;
  pose_between(step.before, step.after, share, at.p_world_body_m, at.q_world_body);
  for (int f = 0; f < kFlippers; ++f) {
    const double from = step.before_flipper_rad[f];
    at.flipper_rad[f] = from + share * (step.after_flipper_rad[f] - from);
    if (!std::isfinite(at.flipper_rad[f])) return Status::not_finite;
  }
  body = at;
  return Status::ok;
}

Status RayCaster::aim(const SensorMount& mount, const BodyInstant& body, Aim& aim) const {
  if (!is_finite(mount.p_body_sensor_m) || !rotates(mount.q_body_sensor) || !is_finite(body.p_world_body_m) ||
      !rotates(body.q_world_body))
    return Status::not_finite;
  for (const double angle : body.flipper_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  aim.p_world_sensor_m = body.p_world_body_m + rotate(body.q_world_body, mount.p_body_sensor_m);
  aim.q_world_sensor = body.q_world_body * mount.q_body_sensor;
  aim.mount = mount;
  if (shell_ != nullptr) aim.posture = VehicleShell::posture(body.flipper_rad);
  return Status::ok;
}

RangeHit RayCaster::cast(const Aim& aim, const Vec3& direction_sensor, double max_range_m) const {
  if (place_ != nullptr) {
    const Vec3 direction = rotate(aim.q_world_sensor, direction_sensor);
    return to_range(place_->cast(aim.p_world_sensor_m, direction, max_range_m), direction);
  }
  // The robot first: what it hides need not be looked for.
  ShellHit own;
  const Ray ray_body{aim.mount.p_body_sensor_m, rotate(aim.mount.q_body_sensor, direction_sensor)};
  const bool hidden = shell_ != nullptr && shell_->meet(ray_body, aim.posture, max_range_m, own);
  const Vec3 direction = rotate(aim.q_world_sensor, direction_sensor);
  const Hit hit = world_->cast(aim.p_world_sensor_m, direction, hidden ? own.range_m : max_range_m);
  if (hidden && !(hit && hit.range_m < own.range_m)) return to_range(own, ray_body.direction);
  return to_range(hit, direction);
}

RangeHit RayCaster::cast_brute_force(const Aim& aim, const Vec3& direction_sensor, double max_range_m) const {
  if (place_ != nullptr) return cast(aim, direction_sensor, max_range_m);
  const Vec3 direction = rotate(aim.q_world_sensor, direction_sensor);
  const RangeHit far =
      to_range(world_->cast_brute_force(aim.p_world_sensor_m, direction, max_range_m), direction);
  if (shell_ == nullptr) return far;
  ShellHit own;
  const Ray ray_body{aim.mount.p_body_sensor_m, rotate(aim.mount.q_body_sensor, direction_sensor)};
  if (!shell_->meet_every_part(ray_body, aim.posture, max_range_m, own)) return far;
  return far && far.range_m < own.range_m ? far : to_range(own, ray_body.direction);
}

}  // namespace sortie::hil
