// SPDX-License-Identifier: BSD-3-Clause
#include "planner/missing_ground.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::planner {
namespace {

constexpr double kFarthestWindow_m = 1e5;
constexpr double kMostHeight_m = 1e4;
constexpr double kAxle_m = 0.25;        // from here on a cell lies before the front axle
constexpr double kBellyHalf_m = 0.147;  // between the tracks

bool is_told(const HeightCell& cell) {
  return cell.state == HeightState::known && cell.low_m <= cell.high_m && cell.low_m > -kMostHeight_m &&
         cell.high_m < kMostHeight_m;
}

/// First and last cell whose middle is within `around` cells of `place`, in cells: mirrored by -place.
void middles_within(double place, double around, std::int64_t& first, int& wide) {
  first = -static_cast<std::int64_t>(rt::floor(around - place + 0.5));
  wide = static_cast<int>(static_cast<std::int64_t>(rt::floor(place + around - 0.5)) - first + 1);
}

}  // namespace

Status MissingGround::take(const HeightView& view, const StandPose& pose, double ahead, double around_m,
                           const MissingConfig& config) {
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.yaw_rad) ||
      !std::isfinite(view.cell_m))
    return Status::not_finite;
  if (view.cell == nullptr || std::fabs(pose.x_m) > kFarthestWindow_m ||
      std::fabs(pose.y_m) > kFarthestWindow_m || !(view.cell_m >= 0.01 && view.cell_m <= 1.0) ||
      !(around_m / view.cell_m <= kHalf))
    return Status::out_of_range;
  pose_ = pose;
  const rt::SinCos yaw = rt::sincos(pose.yaw_rad);
  cos_ = yaw.cos;
  sin_ = yaw.sin;
  ahead_ = ahead;
  cell_m_ = view.cell_m;
  middles_within(pose.x_m / cell_m_, around_m / cell_m_, first_i_, wide_i_);
  middles_within(pose.y_m / cell_m_, around_m / cell_m_, first_j_, wide_j_);
  for (int v = 0; v < wide_j_; ++v) {
    for (int u = 0; u < wide_i_; ++u) {
      HeightCell& seen = seen_[index(u, v)];
      seen = view.cell(view.ground, first_i_ + u, first_j_ + v);
      if (seen.state == HeightState::known && !is_told(seen)) seen = {};
      if (seen.state == HeightState::bounded_above && !(std::fabs(seen.high_m) < kMostHeight_m)) seen = {};
      kind_[index(u, v)] = seen.state == HeightState::known ? Kind::known : Kind::open;
      cells_[index(u, v)] = seen;
    }
  }
  for (int v = 0; v < wide_j_; ++v)
    for (int u = 0; u < wide_i_; ++u)
      if (kind_[index(u, v)] != Kind::known) bound_missing(u, v, config);
  return Status::ok;
}

void MissingGround::bound_missing(int u, int v, const MissingConfig& config) {
  const auto reach = std::min(7, static_cast<int>(config.reach_m / cell_m_ + 0.5));
  double low = kMostHeight_m;
  double high = -kMostHeight_m;
  int nearest = 0;
  for (int ring = 1; ring <= reach + 1; ++ring) {
    if (nearest == 0 && ring > reach) break;
    if (nearest != 0 && ring > nearest + 1) break;
    for (int k = -ring; k <= ring; ++k) {
      // Over a whole row at the ring's ends, else its two sides.
      for (int l = -ring; l <= ring; l += (k == -ring || k == ring) ? 1 : 2 * ring) {
        const int a = u + l;
        const int b = v + k;
        if (a < 0 || b < 0 || a >= wide_i_ || b >= wide_j_) continue;
        const HeightCell& near = seen_[index(a, b)];
        if (near.state != HeightState::known) continue;
        low = std::min(low, near.low_m);
        high = std::max(high, near.high_m);
        if (nearest == 0) nearest = ring;
      }
    }
  }
  if (nearest == 0) return;
  const double widened = config.slope * cell_m_ * nearest;
  HeightCell& cell = cells_[index(u, v)];
  const HeightCell& seen = seen_[index(u, v)];
  low -= widened;
  high += widened;
  if (seen.state == HeightState::bounded_above && seen.high_m < high) {
    high = seen.high_m;
    low = std::min(low, high - config.hole_m);
  }
  cell = {low, high, HeightState::known};
  kind_[index(u, v)] = Kind::bounded;
}

void MissingGround::body_place(int u, int v, double& ahead_m, double& left_m) const {
  const double x = (static_cast<double>(first_i_ + u) + 0.5) * cell_m_ - pose_.x_m;
  const double y = (static_cast<double>(first_j_ + v) + 0.5) * cell_m_ - pose_.y_m;
  ahead_m = cos_ * x + sin_ * y;
  left_m = cos_ * y - sin_ * x;
}

void MissingGround::under(std::span<const StandPose> places, double half_length_m, double half_width_m,
                          Under& under) const {
  under = {};
  double squared[kMostNamed]{};
  std::array<rt::SinCos, 8> turn{};
  const std::size_t count = std::min(places.size(), turn.size());
  for (std::size_t p = 0; p < count; ++p) turn[p] = rt::sincos(places[p].yaw_rad);
  for (int v = 0; v < wide_j_; ++v) {
    for (int u = 0; u < wide_i_; ++u) {
      const Kind kind = kind_[index(u, v)];
      if (kind == Kind::known) continue;
      const double cx = (static_cast<double>(first_i_ + u) + 0.5) * cell_m_;
      const double cy = (static_cast<double>(first_j_ + v) + 0.5) * cell_m_;
      bool covered = false;
      for (std::size_t p = 0; p < count && !covered; ++p) {
        const double x = cx - places[p].x_m;
        const double y = cy - places[p].y_m;
        covered = std::fabs(turn[p].cos * x + turn[p].sin * y) <= half_length_m &&
                  std::fabs(turn[p].cos * y - turn[p].sin * x) <= half_width_m;
      }
      if (!covered) continue;
      ++under.missing;
      if (kind == Kind::open) ++under.open;
      const double x = cx - pose_.x_m;
      const double y = cy - pose_.y_m;
      const double far = x * x + y * y;
      // Insertion: a full list drops its farthest.
      std::uint32_t at = under.cells.size();
      if (at == kMostNamed) {
        if (far >= squared[at - 1]) continue;
        --at;
      } else {
        (void)under.cells.push_back({});
      }
      for (; at > 0 && squared[at - 1] > far; --at) {
        squared[at] = squared[at - 1];
        under.cells[at] = under.cells[at - 1];
      }
      squared[at] = far;
      under.cells[at] = {first_i_ + u, first_j_ + v};
    }
  }
}

HeightView MissingGround::view(int point) {
  point_ = point;
  return {this, &MissingGround::cell, cell_m_};
}

bool MissingGround::inside(std::int64_t i, std::int64_t j) const {
  return i >= first_i_ && j >= first_j_ && i < first_i_ + wide_i_ && j < first_j_ + wide_j_;
}

HeightCell MissingGround::cell(const void* self, std::int64_t i, std::int64_t j) {
  const auto& g = *static_cast<const MissingGround*>(self);
  if (!g.inside(i, j)) return {};
  const auto u = static_cast<int>(i - g.first_i_);
  const auto v = static_cast<int>(j - g.first_j_);
  const HeightCell& cell = g.cells_[index(u, v)];
  const Kind kind = g.kind_[index(u, v)];
  if (kind == Kind::known) return cell;
  if (kind == Kind::open) return {};
  double share = 0.5;
  double ahead{};
  double left{};
  g.body_place(u, v, ahead, left);
  const double side = left > 0.0 ? 1.0 : left < 0.0 ? 0.0 : 0.5;
  const bool before_axle = g.ahead_ * ahead > kAxle_m;
  switch (g.point_) {
    case 1:
      share = 0.0;
      break;
    case 2:
      share = 1.0;
      break;
    case 3:
      share = side;
      break;
    case 4:
      share = 1.0 - side;
      break;
    case 5:
      share = before_axle ? 0.0 : 1.0;
      break;
    case 6:
      share = before_axle ? 1.0 : 0.0;
      break;
    case 7:
      share = std::fabs(left) < kBellyHalf_m ? 1.0 : 0.0;
      break;
    default:
      break;
  }
  const double height = cell.low_m + share * (cell.high_m - cell.low_m);
  return {height, height, HeightState::known};
}

}  // namespace sortie::planner
