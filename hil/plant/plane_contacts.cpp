// SPDX-License-Identifier: BSD-3-Clause
// Contacts of the vehicle's parts with a half-space, in closed form. A track gives rows of stations along
// both edges of the run that faces the plane, so that load and friction spread over its length.
#include <cmath>

#include "hil/plant/contact_finder.hpp"

namespace sortie::hil {
namespace {

constexpr double kLyingOnSide = 0.2;  ///< share of the normal in a wheel's plane below which both sides count

}  // namespace

void ContactFinder::half_space_contacts(const BodyPose& pose, const MassState& state, int index) {
  const rt::convex::HalfSpace& plane = scene_->half_spaces()[static_cast<std::uint32_t>(index)];
  const Vec3 up{plane.normal.x, plane.normal.y, plane.normal.z};
  const double height = dot(up, pose.p_world_m) - plane.offset_m;
  if (height > reach_m_ + margin_m_) return;
  const Vec3 normal = back(pose.R_world_body, up);
  box_on_plane(normal, height, index);
  for (int part = 1; part < kParts; ++part) track_on_plane(part, state, normal, height, index);
}

void ContactFinder::box_on_plane(const Vec3& normal, double height_m, int index) {
  const Vec3& c = model_->config().body_centre_m;
  const Vec3& h = model_->config().body_half_m;
  const double lowest = dot(normal, c) + height_m - std::fabs(normal.x) * h.x - std::fabs(normal.y) * h.y -
                        std::fabs(normal.z) * h.z;
  if (lowest > margin_m_) return;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3 point{c.x + ((corner & 1u) != 0 ? h.x : -h.x), c.y + ((corner & 2u) != 0 ? h.y : -h.y),
                     c.z + ((corner & 4u) != 0 ? h.z : -h.z)};
    const double gap = dot(normal, point) + height_m;
    if (gap <= margin_m_) add(0, -1 - index, corner, point, normal, gap);
  }
}

void ContactFinder::track_on_plane(int part, const MassState& state, const Vec3& normal, double height_m,
                                   int index) {
  const VehicleConfig& config = model_->config();
  const bool flipper = part >= 3;
  Vec3 wheel[2];
  double radius[2];
  double half_width = 0.0;
  if (flipper) {
    const int f = joint_of(part);
    wheel[0] = model_->pivot(f);
    const double ahead = f < 2 ? config.flipper_length_m : -config.flipper_length_m;
    wheel[1] = wheel[0] + Vec3{ahead * state.cosine[f], 0.0, config.flipper_length_m * state.sine[f]};
    radius[0] = config.flipper_large_radius_m;
    radius[1] = config.flipper_small_radius_m;
    half_width = 0.5 * config.flipper_width_m;
  } else {
    const Vec3& c = config.track_centre_m;
    wheel[0] = {c.x - config.track_half_length_m, side_of(part) * c.y, c.z};
    wheel[1] = {c.x + config.track_half_length_m, side_of(part) * c.y, c.z};
    radius[0] = radius[1] = config.track_radius_m;
    half_width = 0.5 * config.track_width_m;
  }
  const double in_plane = std::sqrt(normal.x * normal.x + normal.z * normal.z);
  // Lying flat on its side, every direction is as low: down and up of the body then.
  const Vec3 down =
      in_plane > 1e-9 ? Vec3{-normal.x / in_plane, 0.0, -normal.z / in_plane} : Vec3{0.0, 0.0, -1.0};
  const int stations = config.mode == ContactMode::belt && !flipper ? config.belt_stations : 2;
  for (int turn = 0; turn < (in_plane < kLyingOnSide ? 2 : 1); ++turn) {
    const double sign = turn == 0 ? 1.0 : -1.0;
    const Vec3 from = wheel[0] + (sign * radius[0]) * down;
    const Vec3 to = wheel[1] + (sign * radius[1]) * down;
    for (int station = 0; station < stations; ++station) {
      const double share = static_cast<double>(station) / static_cast<double>(stations - 1);
      const Vec3 middle = from + share * (to - from);
      for (int edge = 0; edge < 2; ++edge) {
        // Edges in the order inner, outer: the same on both sides of the vehicle.
        const double across = (edge == 0 ? -half_width : half_width) * side_of(part);
        const Vec3 point{middle.x, middle.y + across, middle.z};
        const double gap = dot(normal, point) + height_m;
        const auto feature = static_cast<std::uint32_t>(turn * 32 + station * 2 + edge);
        if (gap <= margin_m_) add(part, -1 - index, feature, point, normal, gap);
      }
    }
  }
}

}  // namespace sortie::hil
