// SPDX-License-Identifier: BSD-3-Clause
// Inertia of a base with four flippers, each one joint away: composite rigid body in closed form.
#include "hil/plant/vehicle_model.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace sortie::hil {
namespace {

void require(bool good, const char* cure) {
  if (!good) throw std::runtime_error(std::string("hil plant: ") + cure);
}

bool positive(double value) { return value > 0.0 && value < 1e6; }
bool positive(const Vec3& v) { return positive(v.x) && positive(v.y) && positive(v.z); }

void check(const VehicleConfig& c) {
  require(positive(c.mass_scale) && positive(c.body_mass_kg) && positive(c.track_mass_kg) &&
              positive(c.flipper_mass_kg),
          "masses must be above 0");
  require(c.load_mass_kg >= 0.0 && c.load_mass_kg < 1e6 && is_finite(c.load_centre_m),
          "load_mass_kg must not lie below 0, and load_centre_m must be finite");
  require(
      positive(c.body_inertia_kg_m2) && positive(c.track_inertia_kg_m2) && positive(c.flipper_inertia_kg_m2),
      "inertias must be above 0");
  require(positive(c.body_half_m) && positive(c.track_half_length_m) && positive(c.track_radius_m) &&
              positive(c.track_width_m) && positive(c.flipper_length_m) &&
              positive(c.flipper_large_radius_m) && positive(c.flipper_small_radius_m) &&
              positive(c.flipper_width_m),
          "lengths of the outline must be above 0");
  require(positive(c.servo_stiffness_nm_rad) && positive(c.servo_damping_nms_rad) &&
              c.servo_torque_nm >= 0.0 && c.servo_rate_rad_s >= 0.0,
          "servo_stiffness_nm_rad and servo_damping_nms_rad must be above 0, limits not below");
  require(c.friction >= 0.0 && c.friction <= 100.0 && c.body_friction >= 0.0 && c.body_friction <= 100.0,
          "friction and body_friction must lie in 0 to 100");
  require(c.steering_efficiency > 0.0 && c.steering_efficiency <= 10.0,
          "steering_efficiency must be above 0");
  require(c.icr_left_m - c.icr_right_m > 1e-3, "icr_left_m must lie left of icr_right_m");
  require(std::isfinite(c.icr_x_m), "icr_x_m must be finite");
  require(c.belt_stations >= 2 && c.belt_stations <= 8, "belt_stations must lie in 2 to 8");
}

/// Adds a point mass and a diagonal inertia about it to an inertia about the origin.
void add_inertia(Matrix3& sum, double mass, const Vec3& c, const Vec3& own) {
  const double squared = dot(c, c);
  const double at[3] = {c.x, c.y, c.z};
  const double diagonal[3] = {own.x, own.y, own.z};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) sum.m[i][j] -= mass * at[i] * at[j];
    sum.m[i][i] += mass * squared + diagonal[i];
  }
}

}  // namespace

VehicleModel::VehicleModel(const VehicleConfig& config) : config_(config) {
  check(config);
  const double s = config.mass_scale;
  const Vec3 left = config.track_centre_m;
  const Vec3 right{left.x, -left.y, left.z};
  const double body = s * config.body_mass_kg;
  const double track = s * config.track_mass_kg;
  fixed_mass_kg_ = body + 2.0 * track;
  fixed_moment_ = body * config.body_centre_m + track * (left + right);
  add_inertia(fixed_inertia_, body, config.body_centre_m, s * config.body_inertia_kg_m2);
  add_inertia(fixed_inertia_, track, left, s * config.track_inertia_kg_m2);
  add_inertia(fixed_inertia_, track, right, s * config.track_inertia_kg_m2);
  if (config.load_mass_kg > 0.0) {
    const double load = s * config.load_mass_kg;
    fixed_mass_kg_ += load;
    fixed_moment_ = fixed_moment_ + load * config.load_centre_m;
    add_inertia(fixed_inertia_, load, config.load_centre_m, {});
  }
  flipper_mass_kg_ = s * config.flipper_mass_kg;
  flipper_inertia_ = s * config.flipper_inertia_kg_m2;
  mass_kg_ = fixed_mass_kg_ + kFlippers * flipper_mass_kg_;
  gyration_m_ = std::sqrt(s * config.body_inertia_kg_m2.x / mass_kg_);

  shapes_[0] = rt::convex::make_box({config.body_half_m.x, config.body_half_m.y, config.body_half_m.z});
  for (int part = 1; part < kParts; ++part) {
    shapes_[part] = part < 3
                        ? rt::convex::make_track(config.track_radius_m, config.track_radius_m,
                                                 2.0 * config.track_half_length_m, 0.5 * config.track_width_m)
                        : rt::convex::make_track(config.flipper_large_radius_m, config.flipper_small_radius_m,
                                                 config.flipper_length_m, 0.5 * config.flipper_width_m);
  }
}

Vec3 VehicleModel::pivot(int flipper) const {
  const Vec3& p = config_.flipper_pivot_m;
  return {flipper < 2 ? p.x : -p.x, flipper % 2 == 0 ? p.y : -p.y, p.z};
}

void VehicleModel::mass_at(const double (&angle_rad)[kFlippers], MassState& out) const {
  Vec3 moment = fixed_moment_;
  Matrix3 inertia = fixed_inertia_;
  ArrowMatrix& matrix = out.matrix;
  for (int f = 0; f < kFlippers; ++f) {
    const rt::SinCos turn = rt::sincos(angle_rad[f]);
    const double ahead = f < 2 ? 1.0 : -1.0;
    out.sine[f] = turn.sin;
    out.cosine[f] = turn.cos;
    const Vec3 along{ahead * turn.cos, 0.0, turn.sin};  // of the flipper; across is y; normal is along x y
    out.arm_m[f] = config_.flipper_com_m * along;
    out.centre_m[f] = pivot(f) + out.arm_m[f];
    moment = moment + flipper_mass_kg_ * out.centre_m[f];
    add_inertia(inertia, flipper_mass_kg_, out.centre_m[f], {0.0, flipper_inertia_.y, 0.0});
    // I = a l l^T + c (1 - l l^T), in x and z.
    const double difference = flipper_inertia_.x - flipper_inertia_.z;
    inertia.m[0][0] += flipper_inertia_.z + difference * along.x * along.x;
    inertia.m[2][2] += flipper_inertia_.z + difference * along.z * along.z;
    inertia.m[0][2] += difference * along.x * along.z;
    inertia.m[2][0] += difference * along.x * along.z;

    const double axis = axis_sign(f);
    const Vec3 lever = axis * Vec3{out.arm_m[f].z, 0.0, -out.arm_m[f].x};  // axis x arm
    const Vec3 push = flipper_mass_kg_ * lever;
    const Vec3 turned = cross(out.centre_m[f], push) + Vec3{0.0, axis * flipper_inertia_.y, 0.0};
    const double column[6] = {push.x, push.y, push.z, turned.x, turned.y, turned.z};
    for (int i = 0; i < 6; ++i) {
      matrix.column[f][i] = column[i];
      matrix.row[f][i] = column[i];
    }
    matrix.diagonal[f] = dot(lever, push) + flipper_inertia_.y;
  }
  out.mass_kg = mass_kg_;
  out.com_m = (1.0 / mass_kg_) * moment;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      matrix.base[i][j] = i == j ? mass_kg_ : 0.0;
      matrix.base[3 + i][3 + j] = inertia.m[i][j];
    }
  }
  const double skew[3][3] = {
      {0.0, -moment.z, moment.y}, {moment.z, 0.0, -moment.x}, {-moment.y, moment.x, 0.0}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      matrix.base[3 + i][j] = skew[i][j];
      matrix.base[i][3 + j] = skew[j][i];
    }
  }
}

void VehicleModel::joint_motion_force(const MassState& state, const Generalised& velocity,
                                      double (&force_nm)[kFlippers]) const {
  for (int f = 0; f < kFlippers; ++f) {
    const double axis = axis_sign(f);
    const Vec3& s = state.arm_m[f];
    const Vec3 moved = axis * Vec3{s.z, 0.0, -s.x};  // ds/dq
    const Vec3 w = velocity.angular + Vec3{0.0, axis * velocity.joint[f], 0.0};
    const Vec3 v = velocity.linear + cross(velocity.angular, state.centre_m[f]) + velocity.joint[f] * moved;
    // d(v)/dq with q' fixed, and d(w . I w / 2)/dq where I turns with the flipper.
    const Vec3 dv = cross(w, moved);
    const double ahead = f < 2 ? 1.0 : -1.0;
    const double along_x = ahead * state.cosine[f];
    const double along_z = state.sine[f];
    const double along = along_x * w.x + along_z * w.z;
    const double turned = axis * (along_z * w.x - along_x * w.z);
    force_nm[f] = flipper_mass_kg_ * dot(v, dv) + (flipper_inertia_.x - flipper_inertia_.z) * along * turned;
  }
}

rt::convex::Convex VehicleModel::shape(int part, const MassState& state) const {
  rt::convex::Convex shape = shapes_[part];
  if (part == 0) {
    shape.p_world_m = {config_.body_centre_m.x, config_.body_centre_m.y, config_.body_centre_m.z};
  } else if (part < 3) {
    const Vec3& c = config_.track_centre_m;
    shape.p_world_m = {c.x - config_.track_half_length_m, side_of(part) * c.y, c.z};
  } else {
    const int f = joint_of(part);
    const Vec3 p = pivot(f);
    shape.p_world_m = {p.x, p.y, p.z};
    // Columns: along the flipper, the axle, and the normal that makes a right-handed frame of them.
    const double ahead = f < 2 ? 1.0 : -1.0;
    const double x = ahead * state.cosine[f];
    const double z = state.sine[f];
    shape.R_world_body = {{x, 0.0, -z, 0.0, 1.0, 0.0, z, 0.0, x}};
  }
  return shape;
}

}  // namespace sortie::hil
