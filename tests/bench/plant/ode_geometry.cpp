// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/plant/ode_geometry.hpp"

#if __has_include(<ode/ode.h>) && defined(SORTIE_PEER_ODE)
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hil/plant/matrix3.hpp"
#include "hil/plant/vehicle_model.hpp"

namespace sortie::bench {

namespace {

using hil::Vec3;

constexpr double kHalfPi = 1.57079632679489662;

/// Adds parts to a body whose frame sits in the centre of mass.
class OdeParts {
 public:
  OdeParts(const OdeBody& body, int side) : body_(body), side_(side) {}

  void box(const Vec3& centre_m, const Vec3& half_m, double pitch_rad) const {
    attach(dCreateBox(body_.space, 2 * half_m.x, 2 * half_m.y, 2 * half_m.z), centre_m, 0, 1, pitch_rad);
  }
  /// Its axis lies across the vehicle.
  void wheel(const Vec3& centre_m, double radius_m, double width_m) const {
    attach(dCreateCylinder(body_.space, radius_m, width_m), centre_m, 1, 0, kHalfPi);
  }

 private:
  void attach(dGeomID geometry, const Vec3& centre_m, double axis_x, double axis_y, double angle_rad) const {
    dGeomSetBody(geometry, body_.body);
    const Vec3 at = centre_m - body_.com_m;
    dGeomSetOffsetPosition(geometry, at.x, at.y, at.z);
    dMatrix3 turn;
    dRFromAxisAndAngle(turn, axis_x, axis_y, 0, angle_rad);
    dGeomSetOffsetRotation(geometry, turn);
    dGeomSetData(geometry, reinterpret_cast<void*>(static_cast<std::intptr_t>(side_)));
  }

  OdeBody body_;
  int side_;
};

void add_track(const OdeBody& body, const hil::VehicleConfig& c, int side) {
  const OdeParts parts(body, side);
  const Vec3 centre{c.track_centre_m.x, side * c.track_centre_m.y, c.track_centre_m.z};
  parts.box(centre, {c.track_half_length_m, 0.5 * c.track_width_m, c.track_radius_m}, 0);
  for (const double end : {-1.0, 1.0})
    parts.wheel(centre + Vec3{end * c.track_half_length_m, 0, 0}, c.track_radius_m, c.track_width_m);
}

void add_flipper(const OdeBody& body, const hil::VehicleConfig& c, int flipper, double angle_rad) {
  const double ahead = flipper < 2 ? 1.0 : -1.0;
  const int side = flipper % 2 == 0 ? 1 : -1;
  const OdeParts parts(body, side);
  const Vec3 pivot{ahead * c.flipper_pivot_m.x, side * c.flipper_pivot_m.y, c.flipper_pivot_m.z};
  const Vec3 along{ahead * std::cos(angle_rad), 0, std::sin(angle_rad)};
  const Vec3 tip = pivot + c.flipper_length_m * along;
  parts.wheel(pivot, c.flipper_large_radius_m, c.flipper_width_m);
  parts.wheel(tip, c.flipper_small_radius_m, c.flipper_width_m);
  // The bars' outer faces are the common tangents of the wheels.
  const double sine = (c.flipper_large_radius_m - c.flipper_small_radius_m) / c.flipper_length_m;
  const double cosine = std::sqrt(1 - sine * sine);
  const double half = 0.5 * c.flipper_small_radius_m;
  for (const double up : {-1.0, 1.0}) {
    const Vec3 outward = sine * along + (up * cosine) * Vec3{-along.z, 0, along.x};
    const Vec3 face =
        0.5 * (pivot + tip) + (0.5 * (c.flipper_large_radius_m + c.flipper_small_radius_m)) * outward;
    // A pitch turns x down: the box's x axis lies across `outward`, in the plane of the wheels.
    const double pitch = std::atan2(outward.x, outward.z);
    parts.box(face - half * outward, {0.5 * c.flipper_length_m * cosine, 0.5 * c.flipper_width_m, half},
              pitch);
  }
}

}  // namespace

dSpaceID add_ode_obstacles(const hil::PlantScene& scene) {
  const dSpaceID space = dSimpleSpaceCreate(nullptr);
  for (const auto& plane : scene.half_spaces())
    dCreatePlane(space, plane.normal.x, plane.normal.y, plane.normal.z, plane.offset_m);
  for (const auto& solid : scene.solids()) {
    const rt::convex::Convex& shape = solid.shape;
    if (shape.kind != rt::convex::Kind::box) continue;
    const dGeomID box = dCreateBox(space, 2 * shape.half_m.x, 2 * shape.half_m.y, 2 * shape.half_m.z);
    dGeomSetPosition(box, shape.p_world_m.x, shape.p_world_m.y, shape.p_world_m.z);
    const double(&m)[9] = shape.R_world_body.m;
    const dMatrix3 turn{m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0};
    dGeomSetRotation(box, turn);
  }
  return space;
}

OdeBody add_ode_vehicle(dWorldID world, const hil::VehicleConfig& config, const BenchScene& scene) {
  OdeBody made;
  made.body = dBodyCreate(world);
  made.space = dSimpleSpaceCreate(nullptr);
  const hil::VehicleModel model(config);
  hil::MassState state;
  model.mass_at(scene.flipper_rad, state);
  made.com_m = state.com_m;
  // Inertia about the origin, brought to the centre of mass.
  const double m = state.mass_kg;
  const Vec3& c = state.com_m;
  const auto& whole = state.matrix.base;
  dMass mass;
  dMassSetParameters(&mass, m, 0, 0, 0, whole[3][3] - m * (c.y * c.y + c.z * c.z),
                     whole[4][4] - m * (c.x * c.x + c.z * c.z), whole[5][5] - m * (c.x * c.x + c.y * c.y),
                     whole[3][4] + m * c.x * c.y, whole[3][5] + m * c.x * c.z, whole[4][5] + m * c.y * c.z);
  dBodySetMass(made.body, &mass);
  const OdeParts box(made, 0);
  box.box(config.body_centre_m, config.body_half_m, 0);
  for (const int side : {1, -1}) add_track(made, config, side);
  for (int f = 0; f < hil::kFlippers; ++f) add_flipper(made, config, f, scene.flipper_rad[f]);
  const hil::Quat& q = scene.start.q_world_body;
  const Vec3 p = scene.start.p_world_m + hil::rotate(q, made.com_m);
  const dQuaternion turn{q.w, q.x, q.y, q.z};
  dBodySetPosition(made.body, p.x, p.y, p.z);
  dBodySetQuaternion(made.body, turn);
  return made;
}

}  // namespace sortie::bench
#endif
