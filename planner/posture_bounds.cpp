// SPDX-License-Identifier: BSD-3-Clause
#include "planner/posture_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "planner/posture_slice.hpp"

namespace sortie::planner {
namespace {

constexpr int kCoarse =
    14;  // boxes along pitch, and along roll, at first: wider ones are hardly ever thrown out
constexpr double kFinest_rad = 0.003;  // half a box: no box is cut below it
constexpr double kNothing_m = -1e9;
constexpr double kKnown_m = 2e4;  // no lift is as large where the ground is bounded: heights end at 1e4

/// The lower side of a slice over a box of tilts: how much each of its points moves, and what that leaves.
struct BoxedSlice {
  TiltedSlice mid;
  double off_x, off_z[2], off_y;
  double squeeze_low, squeeze_high;
  double run_begin, run_end;  // of the run's ends as they are in the middle
  double run_least_z, run_steepest;
  bool upright;  // so steep that either run may be the lower one

  BoxedSlice(const OutlineSlice& s, const Tilt& tilt, double half) : mid(s, tilt) {
    const double y = std::fabs(mid.y[0]) + mid.radius[0];
    off_x = 0.0;
    off_y = 0.0;
    for (int k = 0; k < 2; ++k) {
      const double r = mid.radius[k];
      const double moved =
          (std::sqrt(mid.x[k] * mid.x[k] + s.y_m * s.y_m + mid.z[k] * mid.z[k]) + r) * 2.0 * half;
      const double reach_z = std::fabs(mid.z[k]) + r + moved;
      off_z[k] = (std::fabs(mid.x[k]) + r + moved + y + moved) * half;
      off_x = std::max(off_x, (reach_z + (y + moved) * (std::fabs(tilt.pitch.sin) + half)) * half);
      off_y = std::max(
          off_y, (reach_z + std::fabs(mid.x[k] * tilt.pitch.sin) + y * std::fabs(tilt.roll.sin) + r) * half);
    }
    const double axis = std::fabs(tilt.roll.sin * tilt.pitch.cos);
    const double axis_high = std::min(1.0, axis + 2.0 * half);
    const double axis_low = std::max(0.0, axis - 2.0 * half);
    squeeze_low = std::sqrt(1.0 - axis_high * axis_high);
    squeeze_high = std::sqrt(1.0 - axis_low * axis_low);
    upright = mid.x[1] - mid.x[0] < 2.0 * off_x + 0.02;
    run_begin = mid.run_x[0];
    run_end = mid.run_x[1];
    run_least_z = std::min(mid.run_z[0], mid.run_z[1]);
    run_steepest = 1e9;
    if (upright) {
      for (int run = 0; run < 2; ++run) {
        for (int k = 0; k < 2; ++k) {
          const rt::Vector3 end = tilt.turn({s.x_m[k] + s.radius_m[k] * s.run_normal[run][0], s.y_m,
                                             s.z_m[k] + s.radius_m[k] * s.run_normal[run][1]});
          run_begin = std::min(run_begin, end.x);
          run_end = std::max(run_end, end.x);
          run_least_z = std::min(run_least_z, end.z);
        }
      }
    } else {
      const double length = run_end - run_begin - 2.0 * off_x;
      if (length > 1e-3)
        run_steepest = (std::fabs(mid.run_z[1] - mid.run_z[0]) + off_z[0] + off_z[1]) / length;
    }
  }

  double begin() const { return std::min(run_begin, mid.x[0] - kWallShare * mid.radius[0]) - off_x; }
  double end() const { return std::max(run_end, mid.x[1] + kWallShare * mid.radius[1]) + off_x; }

  /// Height of the run at x, where it is not upright, were it as it is in the middle.
  double run_at(double x) const { return mid.run_z[0] + mid.run_slope * (x - mid.run_x[0]); }
  double run_off() const { return std::max(off_z[0], off_z[1]) + run_steepest * off_x; }

  /// The lowest that any point of it can be within `half_x` of x; large where there is none.
  double lowest(double x, double half_x) const {
    double low = -kNothing_m;
    const double slack = off_x + half_x;
    if (x + slack >= run_begin && x - slack <= run_end) {
      low = run_least_z - std::max(off_z[0], off_z[1]);
      if (!upright && run_steepest < kWallSlope)
        low = std::max(
            low, run_at(std::clamp(x, run_begin, run_end)) - run_off() - std::fabs(mid.run_slope) * half_x);
    }
    for (int k = 0; k < 2; ++k) {
      const double r = mid.radius[k];
      const double off = std::max(0.0, std::fabs(x - mid.x[k]) - slack);
      if (off <= kWallShare * r)
        low = std::min(low, mid.z[k] - off_z[k] - squeeze_high * std::sqrt(r * r - off * off));
    }
    return low;
  }

  /// The highest that its lower side can be at x, where all tilts have it there; large elsewhere.
  double highest(double x) const {
    const bool may_run = x >= run_begin - off_x && x <= run_end + off_x;
    if (may_run && (upright || run_steepest > kWallSlope)) return -kNothing_m;
    const double run = may_run ? run_at(std::clamp(x, run_begin, run_end)) + run_off() : kNothing_m;
    if (!upright && x >= run_begin + off_x && x <= run_end - off_x) return run;
    for (int k = 0; k < 2; ++k) {
      if (k == 0 ? x + off_x > run_end : x - off_x < run_begin) continue;
      const double r = mid.radius[k];
      const double off = std::fabs(x - mid.x[k]) + off_x;
      if (off <= kWallShare * r)
        return std::max(run, mid.z[k] + off_z[k] - squeeze_low * std::sqrt(r * r - off * off));
    }
    return -kNothing_m;
  }

  /// The places across that it can lie at, within `half_x` of x.
  Range across(double x, double half_x) const {
    const double slack = off_x + half_x;
    double a = mid.y_at(x - slack);
    double b = mid.y_at(x + slack);
    if (upright) {
      a = mid.y[0];
      b = mid.y[1];
    }
    return {std::min(a, b) - off_y, std::max(a, b) + off_y};
  }
};

/// Least and most height of the ground at a column, between two places across.
Range ground_between(const GroundPatch& ground, int column, const Range& y) {
  const double per_m = 1.0 / ground.spacing_m();
  const auto first = static_cast<int>(rt::floor(y.low * per_m));
  const auto last = static_cast<int>(rt::floor(y.high * per_m)) + 1;
  Range range{1e9, -1e9};
  if (column < -GroundPatch::kHalfColumns || column > GroundPatch::kHalfColumns ||
      first < -GroundPatch::kHalfRows || last > GroundPatch::kHalfRows)
    return {static_cast<double>(GroundPatch::kBottomless), static_cast<double>(GroundPatch::kSkyHigh)};
  for (int row = first; row <= last; ++row) {
    range.low = std::min(range.low, static_cast<double>(ground.low(column, row)));
    range.high = std::max(range.high, static_cast<double>(ground.high(column, row)));
  }
  return range;
}

}  // namespace

PostureBounder::Verdict PostureBounder::try_box(const Outline& outline, const GroundPatch& ground,
                                                const rt::Vector3& com_body, const Box& box, double half) {
  const Tilt tilt(box.pitch_rad, box.roll_rad);
  const double spacing = ground.spacing_m();
  Verdict verdict;
  verdict.least_m = kNothing_m;
  double belly = kNothing_m;
  stretches_.clear();
  bool all_fit = true;
  for (std::uint32_t index = 0; index < kOutlineSlices; ++index) {
    const BoxedSlice slice(outline[index], tilt, half);
    const auto first = static_cast<int>(rt::floor(slice.begin() / spacing));
    const auto last = static_cast<int>(rt::floor(slice.end() / spacing)) + 1;
    double before = kNothing_m;
    for (int column = first; column <= last; ++column) {
      const double x = spacing * column;
      const Range here = ground_between(ground, column, slice.across(x, spacing));
      verdict.least_m = std::max(verdict.least_m, here.low - slice.highest(x));
      if (column > first) {
        const double middle = x - 0.5 * spacing;
        const double most = std::max(before, here.high) - slice.lowest(middle, 0.5 * spacing);
        const Range y = slice.across(middle, 0.5 * spacing);
        all_fit &= stretches_.push_back({middle, 0.5 * (y.low + y.high), 0.5 * (y.high - y.low), most});
        if (outline[index].part == rt::VehiclePart::body) belly = std::max(belly, most);
      }
      before = here.high;
    }
  }
  // Those that can touch must surround the centre of mass: none of eight half-planes through it is without
  // one.
  const rt::Vector3 com = tilt.turn(com_body);
  const double slack = rt::norm(com_body) * 2.0 * half + 0.5 * spacing;
  constexpr double kSlant = 0.70710678118654752;
  std::uint32_t sides = 0;
  verdict.most_m = kNothing_m;
  for (const Stretch& s : stretches_) {
    if (s.most_m < verdict.least_m) continue;
    verdict.most_m = std::max(verdict.most_m, s.most_m);
    const double x = s.x_m - com.x;
    const double y = s.y_m - com.y;
    const double off = slack + s.off_y_m;
    const double along[4] = {x, y, kSlant * (x + y), kSlant * (x - y)};
    for (unsigned k = 0; k < 4; ++k) {
      if (along[k] >= -off) sides |= 1u << (2 * k);
      if (along[k] <= off) sides |= 2u << (2 * k);
    }
  }
  verdict.possible = sides == 0xffu || !all_fit;
  if (!all_fit) verdict.most_m = static_cast<double>(GroundPatch::kSkyHigh);
  verdict.clearance_m = std::max(0.0, verdict.least_m - belly);
  return verdict;
}

Status PostureBounder::bound(const PostureSolver& solver, const FlipperSet& flippers, std::uint32_t units,
                             PostureBounds& out) {
  PostureSolver::Looked as;
  const Status status = solver.looked(flippers, as);
  if (status != Status::ok) return status;
  if (units < kCoarse * kCoarse || units > 4096) return Status::out_of_range;
  const GroundPatch& ground = solver.ground();
  const Outline outline = outline_of(solver.vehicle(), as.flippers);
  const rt::Vector3 com = centre_of_mass(solver.vehicle(), as.flippers);
  PostureBounds bounds;
  double half = kWidest_rad / kCoarse;
  std::uint32_t count = 0;
  for (int i = 0; i < kCoarse; ++i)
    for (int j = 0; j < kCoarse; ++j)
      boxes_[count++] = {half * (2 * i + 1 - kCoarse), half * (2 * j + 1 - kCoarse)};
  for (;;) {
    std::uint32_t kept = 0;
    Range pitch{1e9, -1e9}, roll{1e9, -1e9}, height{1e9, -1e9};
    double clearance = 1e9;
    for (std::uint32_t k = 0; k < count; ++k) {
      const Box box = boxes_[k];
      const Verdict verdict = try_box(outline, ground, com, box, half);
      if (!verdict.possible) continue;
      pitch = {std::min(pitch.low, box.pitch_rad - half), std::max(pitch.high, box.pitch_rad + half)};
      roll = {std::min(roll.low, box.roll_rad - half), std::max(roll.high, box.roll_rad + half)};
      height = {std::min(height.low, verdict.least_m), std::max(height.high, verdict.most_m)};
      clearance = std::min(clearance, verdict.clearance_m);
      boxes_[kept++] = box;
    }
    if (kept == 0) {  // no number of a coarser level stays
      const std::uint32_t units_before = bounds.units;
      bounds = {};
      bounds.units = units_before;
    }
    bounds.units += count;
    bounds.rests = kept > 0;
    bounds.bounded = kept == 0 || (height.low > -kKnown_m && height.high < kKnown_m);
    if (bounds.bounded && kept > 0) {
      bounds.pitch_rad = pitch;
      bounds.roll_rad = roll;
      bounds.height_m = height;
      bounds.least_clearance_m = clearance;
      const double end = kWidest_rad - 1e-9;
      bounds.may_tip = pitch.low < -end || pitch.high > end || roll.low < -end || roll.high > end;
    }
    half *= 0.5;
    if (kept == 0 || 4 * kept > kMostBoxes || bounds.units + 4 * kept > units || half < kFinest_rad) break;
    count = 0;
    for (std::uint32_t k = 0; k < kept; ++k) {
      for (int corner = 0; corner < 4; ++corner)
        next_[count++] = {boxes_[k].pitch_rad + (corner < 2 ? -half : half),
                          boxes_[k].roll_rad + (corner % 2 == 0 ? -half : half)};
    }
    std::swap(boxes_, next_);
  }
  if (as.mirrored) bounds.roll_rad = {-bounds.roll_rad.high, -bounds.roll_rad.low};
  out = bounds;
  return Status::ok;
}

}  // namespace sortie::planner
