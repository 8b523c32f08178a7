// SPDX-License-Identifier: BSD-3-Clause
#include "planner/face_ahead.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::planner {
namespace {

constexpr double kFaceSlope = 2.1445;  // 65 degrees
constexpr double kSlack_m = 0.02;      // an edge in a cell counts at the cell's border, up to 5 cm early
constexpr double kSameTop_m = 0.05;    // a face as high beside it lifts the flipper first

/// A place in the plane of travel: ahead of the origin, and up, m.
struct Spot {
  double ahead{}, up{};
};

/// What leads on one side, after the body was turned: where faces count from, how far it reaches, and how
/// high a face may be.
struct Leading {
  double from{}, reach{}, climbs{};
};

}  // namespace

bool is_face_ahead(const PostureSolver& solver, const FlipperSet& flippers, const Posture& posture,
                   double direction, double advance_m, double climb_rad) {
  PostureSolver::Looked as;
  if (solver.looked(flippers, as) != Status::ok) return true;
  const PostureVehicle& v = solver.vehicle();
  const estimators::TrackProfile& p = v.side;
  const GroundPatch& ground = solver.ground();
  const double spacing = ground.spacing_m();
  const double climb = -direction * posture.pitch_rad;
  const double roll = as.mirrored ? -posture.roll_rad : posture.roll_rad;
  const rt::SinCos turn = rt::sincos(climb);
  const double rim_share = rt::cos(climb_rad);  // from there down a rim is less steep
  const auto turned = [&turn](double ahead, double up) {
    return Spot{ahead * turn.cos - up * turn.sin, ahead * turn.sin + up * turn.cos};
  };
  const double rise_slope = turn.cos > 0.1 ? turn.sin / turn.cos : 0.0;
  const double taper = (p.pivot_radius_m - p.tip_radius_m) / p.flipper_m;
  const auto height = [&](int column, int row) {
    return static_cast<double>(ground.height(direction < 0.0 ? -column : column, row));
  };
  constexpr double kNothing = 0.5 * static_cast<double>(GroundPatch::kUnknown);
  for (int side = 0; side < 2; ++side) {
    const double left = side == 0 ? 1.0 : -1.0;
    const double angle = as.flippers.angle_rad[(direction < 0.0 ? 2 : 0) + side];
    const rt::SinCos out = rt::sincos(angle);
    const Spot pivot = turned(p.pivot_x_m, p.pivot_z_m);
    const Spot tip = turned(p.pivot_x_m + p.flipper_m * out.cos, p.pivot_z_m + p.flipper_m * out.sin);
    const Spot wheel = turned(p.half_length_m, p.axle_m);
    const double lower_run = angle + climb + taper;
    Leading flipper;
    flipper.from = angle + climb < 0.0 ? tip.ahead : pivot.ahead;
    flipper.reach = std::max(tip.ahead + p.tip_radius_m, pivot.ahead + p.pivot_radius_m);
    flipper.climbs = std::fabs(lower_run) <= climb_rad ? tip.up - rim_share * p.tip_radius_m
                                                       : pivot.up - rim_share * p.pivot_radius_m;
    const Leading track{wheel.ahead, wheel.ahead + p.radius_m, wheel.up - rim_share * p.radius_m};
    const auto flipper_row = static_cast<int>(v.flipper_y_m / spacing + 0.5);
    const auto track_row = static_cast<int>(p.half_width_m / spacing + 0.5);
    for (int part = 0; part < 2; ++part) {
      const Leading& leading = part == 0 ? flipper : track;
      const int row = (part == 0 ? flipper_row : track_row) * (side == 0 ? 1 : -1);
      const int beside = flipper_row * (side == 0 ? 1 : -1);
      const double lift = posture.height_m + left * (part == 0 ? v.flipper_y_m : p.half_width_m) * roll;
      const auto first = std::max(-GroundPatch::kHalfColumns, static_cast<int>(leading.from / spacing));
      const auto last =
          std::min(GroundPatch::kHalfColumns - 1, static_cast<int>((leading.reach + advance_m) / spacing));
      for (int column = first; column <= last; ++column) {
        const double below = height(column, row);
        const double top = height(column + 1, row);
        if (below < kNothing || top < kNothing || top - below <= kFaceSlope * spacing) continue;
        const double gone = std::max(0.0, spacing * column - leading.reach);
        if (top <= lift + leading.climbs + gone * rise_slope + kSlack_m) continue;
        if (part == 1 && height(column + 1, beside) >= top - kSameTop_m) continue;
        return true;
      }
    }
  }
  return false;
}

}  // namespace sortie::planner
