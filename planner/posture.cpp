// SPDX-License-Identifier: BSD-3-Clause
#include "planner/posture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/posture_facet.hpp"

namespace sortie::planner {
namespace {

constexpr double kMostTurn_rad = 0.4;  // in one sweep
constexpr double kSteepest_rad = 1.2;  // beyond it nothing rests
constexpr double kSettled_rad = 2e-4;  // a sweep that turns less is the last
constexpr double kMostUnknown = 0.9;   // share of the samples without which no rest is told

Status check(const PostureVehicle& v, const PostureConfig& c) {
  const estimators::TrackProfile& p = v.side;
  const double sizes[] = {p.half_length_m,    p.radius_m,        p.half_width_m,       p.pivot_x_m,
                          p.pivot_radius_m,   p.flipper_m,       p.tip_radius_m,       v.track_width_m,
                          v.flipper_y_m,      v.flipper_width_m, v.belly_half_width_m, v.mass_kg,
                          c.ground.spacing_m, c.touch_m};
  const double rest[] = {p.axle_m,        p.pivot_z_m, p.com_x_m,         p.com_z_m,       v.belly_rear_m,
                         v.belly_front_m, v.belly_z_m, v.flipper_mass_kg, v.flipper_com_m, c.gravity_m_s2};
  for (const double value : sizes)
    if (!std::isfinite(value)) return Status::not_finite;
  for (const double value : rest)
    if (!std::isfinite(value)) return Status::not_finite;
  for (const double value : sizes)
    if (!(value > 0.0 && value < 1e6)) return Status::out_of_range;
  // No point of the vehicle is farther from its origin than samples reach.
  const double reach_m = c.ground.spacing_m * GroundPatch::kHalfColumns;
  for (const double place : {p.axle_m, p.pivot_z_m, p.com_x_m, p.com_z_m, v.belly_z_m, v.flipper_com_m})
    if (!(std::fabs(place) <= reach_m)) return Status::out_of_range;
  if (!(c.gravity_m_s2 > 0.0 && c.gravity_m_s2 < 1e3)) return Status::out_of_range;
  if (v.flipper_mass_kg < 0.0 || 4.0 * v.flipper_mass_kg > v.mass_kg || !(v.belly_rear_m < v.belly_front_m) ||
      std::fabs(p.pivot_radius_m - p.tip_radius_m) >= p.flipper_m || c.sweeps < 1 || c.sweeps > 32)
    return Status::out_of_range;
  const double ahead = std::max({p.pivot_x_m + p.flipper_m + p.tip_radius_m, p.half_length_m + p.radius_m,
                                 v.belly_front_m, -v.belly_rear_m});
  const double aside = std::max(v.flipper_y_m + v.flipper_width_m, p.half_width_m + v.track_width_m);
  if (ahead > reach_m || aside > c.ground.spacing_m * GroundPatch::kHalfRows) return Status::out_of_range;
  return Status::ok;
}

FlipperSet mirrored(const FlipperSet& f) {
  return {{f.angle_rad[1], f.angle_rad[0], f.angle_rad[3], f.angle_rad[2]}};
}

/// As GroundPatch::handedness().
int handedness(const FlipperSet& f) {
  for (int k = 0; k < 4; k += 2)
    if (f.angle_rad[k] != f.angle_rad[k + 1]) return f.angle_rad[k] > f.angle_rad[k + 1] ? -1 : 1;
  return 0;
}

/// Bits of a posture's parts with left and right exchanged.
std::uint32_t mirrored_parts(std::uint32_t parts) {
  return (parts & 1u) | ((parts & 0x2au) << 1) | ((parts & 0x54u) >> 1);
}

}  // namespace

PostureSolver::PostureSolver(const PostureVehicle& vehicle, const PostureConfig& config)
    : usable_(check(vehicle, config)), vehicle_(vehicle), config_(config) {}

Status PostureSolver::look(const HeightView& view, const StandPose& pose) {
  if (usable_ != Status::ok) return usable_;
  const Status filled = ground_.fill(view, pose, config_.ground);
  if (filled != Status::ok) return filled;
  looked_ = true;
  // The higher side is always looked at as the left one, so that a mirrored world costs no digit.
  handedness_ = ground_.handedness();
  if (handedness_ > 0) ground_.mirror();
  return Status::ok;
}

Status PostureSolver::looked(const FlipperSet& asked, Looked& looked) const {
  if (!looked_) return Status::empty;
  for (const double angle : asked.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
    if (std::fabs(angle) > 100.0) return Status::out_of_range;
  }
  const int hand = handedness_ != 0 ? handedness_ : handedness(asked);
  looked = {hand > 0 ? mirrored(asked) : asked, hand > 0, hand == 0};
  return Status::ok;
}

Status PostureSolver::rest(const FlipperSet& asked, const Start& start, Posture& posture) {
  Looked as;
  const Status status = looked(asked, as);
  if (status != Status::ok) return status;
  if (!std::isfinite(start.pitch_rad) || !std::isfinite(start.roll_rad)) return Status::not_finite;
  if (std::max(std::fabs(start.pitch_rad), std::fabs(start.roll_rad)) > kSteepest_rad)
    return Status::out_of_range;
  // Ground and flippers that are their own mirror image leave the hand to the start.
  if (as.own_mirror_image && start.roll_rad < 0.0) as.mirrored = true;
  const Outline outline = outline_of(vehicle_, as.flippers);
  const rt::Vector3 com_body = centre_of_mass(vehicle_, as.flippers);
  Posture found;
  Tilt tilt(start.pitch_rad, as.mirrored ? -start.roll_rad : start.roll_rad);
  LiftCount count;
  bool carried = false;
  bool at_rest = false;  // the lifts are those of the tilt
  for (int sweep = 0; sweep < config_.sweeps; ++sweep) {
    count = lifts_at(outline, ground_, tilt, lifts_);
    if (sweep == 0) {
      found.unknown_share = count.samples == 0 ? 1.0 : static_cast<double>(count.unknown) / count.samples;
      if (found.unknown_share > kMostUnknown) break;
    }
    const rt::Vector3 com = tilt.turn(com_body);
    const SupportPlane plane = support_plane(lifts_, com.x, com.y);
    carried = plane.carried;
    const double turn_x = std::clamp(plane.slope_y, -kMostTurn_rad, kMostTurn_rad) / tilt.pitch.cos;
    const double turn_y = std::clamp(-plane.slope_x, -kMostTurn_rad, kMostTurn_rad);
    found.settled_rad = std::max(std::fabs(turn_x), std::fabs(turn_y));
    at_rest = found.settled_rad < kSettled_rad;
    if (at_rest) break;
    tilt = Tilt(std::clamp(tilt.pitch_rad + turn_y, -kSteepest_rad, kSteepest_rad),
                std::clamp(tilt.roll_rad + turn_x, -kSteepest_rad, kSteepest_rad));
  }
  if (found.unknown_share > kMostUnknown || (!carried && count.unknown > 0) || lifts_.empty()) {
    posture = {};
    posture.unknown_share = found.unknown_share;
    return Status::ok;
  }
  if (as.own_mirror_image && tilt.roll_rad != 0.0 && std::fabs(tilt.roll_rad) < 1e-6) {
    tilt = Tilt(tilt.pitch_rad, 0.0);
    at_rest = false;
  }
  if (!at_rest) (void)lifts_at(outline, ground_, tilt, lifts_);
  found.pitch_rad = tilt.pitch_rad;
  found.roll_rad = tilt.roll_rad;
  weigh_support(config_, outline, lifts_, tilt.turn(com_body), vehicle_.mass_kg, found);
  const bool over = std::fabs(tilt.pitch_rad) >= kSteepest_rad || std::fabs(tilt.roll_rad) >= kSteepest_rad;
  found.rest = carried && !over ? Rest::stands : Rest::tips;
  if (as.mirrored) {
    found.roll_rad = -found.roll_rad;
    found.parts = mirrored_parts(found.parts);
  }
  posture = found;
  return Status::ok;
}

}  // namespace sortie::planner
