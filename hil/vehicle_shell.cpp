// SPDX-License-Identifier: BSD-3-Clause
#include "hil/vehicle_shell.hpp"

#include <algorithm>
#include <cmath>

#include "hil/ray_clip.hpp"

namespace sortie::hil {
namespace {

Contact nearer(const Contact& a, const Contact& b) { return b.range_m < a.range_m ? b : a; }

Contact contact_of(const Clip& clip) {
  if (clip.missed()) return {};
  if (clip.near_m <= 0.0) return {0.0, {}};
  return {clip.near_m, clip.normal};
}

// The part of the ray between the two flanks and within one wheel.
Contact meet_wheel(const Ray& ray, double x_m, double radius_m, const Clip& flanks) {
  Clip clip = flanks;
  clip_wheel(clip, {ray.origin_m.x - x_m, 0.0, ray.origin_m.z}, ray.direction, radius_m);
  return contact_of(clip);
}

Contact meet_box(const Ray& ray, const Vec3& centre_m, const Vec3& half_m) {
  const Vec3 o = ray.origin_m - centre_m;
  Clip clip;
  clip.slab(o.x, ray.direction.x, half_m.x, {1, 0, 0});
  clip.slab(o.y, ray.direction.y, half_m.y, {0, 1, 0});
  clip.slab(o.z, ray.direction.z, half_m.z, {0, 0, 1});
  return contact_of(clip);
}

// True if no point of the ray is within `reach_m` of a point.
bool misses_ball(const Ray& ray, const Vec3& middle_m, double reach_m) {
  const Vec3 to = middle_m - ray.origin_m;
  const double ahead = dot(to, ray.direction);
  return ahead < -reach_m || dot(to, to) - ahead * ahead > reach_m * reach_m;
}

// Radius of a ball about the middle of a wheel pair that holds it.
double reach_of(const WheelPair& pair) {
  const double flat = 0.5 * pair.length_m + std::max(pair.first_radius_m, pair.second_radius_m);
  return std::sqrt(flat * flat + pair.half_width_m * pair.half_width_m);
}

// A wheel pair placed in the body: `x` and `z` are those of its first axis, which lies in the plane y = 0.
Contact meet_pair(const Ray& ray, const WheelPair& pair, const Vec3& start_m, double x, double z) {
  const Vec3 o = ray.origin_m - start_m;
  const Vec3& d = ray.direction;
  const Ray local{{x * o.x + z * o.z, o.y, x * o.z - z * o.x}, {x * d.x + z * d.z, d.y, x * d.z - z * d.x}};
  Contact contact = intersect(local, pair);
  const Vec3 n = contact.normal;
  contact.normal = {x * n.x - z * n.z, n.y, z * n.x + x * n.z};
  return contact;
}

}  // namespace

Contact intersect(const Ray& ray, const WheelPair& pair) {
  Clip flanks;
  flanks.slab(ray.origin_m.y, ray.direction.y, pair.half_width_m, {0, 1, 0});
  if (flanks.missed()) return {};
  Contact best = meet_wheel(ray, 0.0, pair.first_radius_m, flanks);
  best = nearer(best, meet_wheel(ray, pair.length_m, pair.second_radius_m, flanks));
  // Tangents of both circles: normals (sine, +-cosine) at distance r1 from the first axle.
  const double sine = (pair.first_radius_m - pair.second_radius_m) / pair.length_m;
  const double rest = 1.0 - sine * sine;
  if (!(rest > 0.0)) return best;  // one wheel lies within the other
  const double cosine = std::sqrt(rest);
  const Vec3& o = ray.origin_m;
  const Vec3& d = ray.direction;
  Clip bars = flanks;
  bars.half_space(sine * o.x + cosine * o.z - pair.first_radius_m, sine * d.x + cosine * d.z,
                  {sine, 0, cosine});
  bars.half_space(sine * o.x - cosine * o.z - pair.first_radius_m, sine * d.x - cosine * d.z,
                  {sine, 0, -cosine});
  bars.half_space(sine * pair.first_radius_m - o.x, -d.x, {-1, 0, 0});
  bars.half_space(o.x - pair.length_m - sine * pair.second_radius_m, d.x, {1, 0, 0});
  return nearer(best, contact_of(bars));
}

VehicleShell::VehicleShell(const VehicleConfig& v, double height_m)
    : body_centre_m_{v.body_centre_m.x, v.body_centre_m.y, v.body_centre_m.z + height_m},
      body_half_m_(v.body_half_m),
      track_start_m_{v.track_centre_m.x - v.track_half_length_m, v.track_centre_m.y,
                     v.track_centre_m.z + height_m},
      flipper_pivot_m_{v.flipper_pivot_m.x, v.flipper_pivot_m.y, v.flipper_pivot_m.z + height_m},
      track_{v.track_radius_m, v.track_radius_m, 2.0 * v.track_half_length_m, 0.5 * v.track_width_m},
      flipper_{v.flipper_large_radius_m, v.flipper_small_radius_m, v.flipper_length_m,
               0.5 * v.flipper_width_m} {
  constexpr double kSlack_m = 1e-6;  // the box must not cut what a part's own arithmetic still meets
  const double swing =
      std::max(v.flipper_large_radius_m, v.flipper_length_m + v.flipper_small_radius_m) + kSlack_m;
  const double track_x = std::fabs(v.track_centre_m.x) + v.track_half_length_m + v.track_radius_m + kSlack_m;
  const double half_x = std::max(
      {std::fabs(body_centre_m_.x) + body_half_m_.x + kSlack_m, track_x, v.flipper_pivot_m.x + swing});
  const double half_y = std::max({std::fabs(body_centre_m_.y) + body_half_m_.y,
                                  std::fabs(v.track_centre_m.y) + track_.half_width_m,
                                  std::fabs(v.flipper_pivot_m.y) + flipper_.half_width_m}) +
                        kSlack_m;
  const double low = std::min({body_centre_m_.z - body_half_m_.z, track_start_m_.z - v.track_radius_m,
                               flipper_pivot_m_.z - swing}) -
                     kSlack_m;
  const double high = std::max({body_centre_m_.z + body_half_m_.z, track_start_m_.z + v.track_radius_m,
                                flipper_pivot_m_.z + swing}) +
                      kSlack_m;
  body_reach_m_ = norm(body_half_m_) + kSlack_m;
  track_reach_m_ = reach_of(track_) + kSlack_m;
  flipper_reach_m_ = reach_of(flipper_) + kSlack_m;
  bounds_centre_m_ = {0.0, 0.0, 0.5 * (low + high)};
  bounds_half_m_ = {half_x, half_y, 0.5 * (high - low)};
}

ShellPosture VehicleShell::posture(const double (&flipper_rad)[kFlippers]) {
  ShellPosture posture;
  for (int f = 0; f < kFlippers; ++f) {
    const rt::SinCos turn = rt::sincos(flipper_rad[f]);
    posture.sine[f] = turn.sin;
    posture.cosine[f] = turn.cos;
  }
  return posture;
}

bool VehicleShell::meet(const Ray& ray_body, const ShellPosture& posture, double within_m,
                        ShellHit& hit) const {
  if (!(meet_box(ray_body, bounds_centre_m_, bounds_half_m_).range_m < within_m)) return false;
  return meet_parts<false>(ray_body, posture, within_m, hit);
}

bool VehicleShell::meet_every_part(const Ray& ray_body, const ShellPosture& posture, double within_m,
                                   ShellHit& hit) const {
  return meet_parts<true>(ray_body, posture, within_m, hit);
}

template <bool kEveryPart>
bool VehicleShell::meet_parts(const Ray& ray_body, const ShellPosture& posture, double within_m,
                              ShellHit& hit) const {
  bool found = false;
  const auto passes = [&](const Vec3& middle_m, double reach_m) {
    return !kEveryPart && misses_ball(ray_body, middle_m, reach_m);
  };
  const auto offer = [&](const Contact& contact, int part) {
    if (!(contact.range_m < within_m)) return;
    within_m = contact.range_m;
    hit = {contact.range_m, contact.normal, part};
    found = true;
  };
  if (!passes(body_centre_m_, body_reach_m_)) offer(meet_box(ray_body, body_centre_m_, body_half_m_), 0);
  for (int part = 1; part < 3; ++part) {
    const Vec3 start{track_start_m_.x, side_of(part) * track_start_m_.y, track_start_m_.z};
    if (passes(start + Vec3{0.5 * track_.length_m, 0.0, 0.0}, track_reach_m_)) continue;
    offer(meet_pair(ray_body, track_, start, 1.0, 0.0), part);
  }
  for (int part = 3; part < kParts; ++part) {
    const int f = joint_of(part);
    const double ahead = f < 2 ? 1.0 : -1.0;
    const Vec3 pivot{ahead * flipper_pivot_m_.x, side_of(part) * flipper_pivot_m_.y, flipper_pivot_m_.z};
    const Vec3 along{ahead * posture.cosine[f], 0.0, posture.sine[f]};
    if (passes(pivot + 0.5 * flipper_.length_m * along, flipper_reach_m_)) continue;
    offer(meet_pair(ray_body, flipper_, pivot, along.x, along.z), part);
  }
  return found;
}

}  // namespace sortie::hil
