// SPDX-License-Identifier: BSD-3-Clause
// What a body at rest stands on: the polygon of its contacts, and the way of the centre of mass over its
// edges.
#include <algorithm>
#include <cmath>

#include "planner/posture.hpp"

namespace sortie::planner {
namespace {

/// Of each slice only the foremost and the rearmost contact can be a corner.
constexpr std::uint32_t kMostCorners = 2 * kOutlineSlices;
using Corners = rt::FixedVector<rt::Vector3, kMostCorners>;

bool before(const rt::Vector3& a, const rt::Vector3& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

/// Twice the area of a triangle in the level plane: positive where it turns left.
double area(const rt::Vector3& a, const rt::Vector3& b, const rt::Vector3& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Corners of the hull in the level plane, anticlockwise (Andrew's chain). `points` are sorted.
void hull_of(const Corners& points, rt::FixedVector<rt::Vector3, 2 * kMostCorners>& hull) {
  const auto count = static_cast<int>(points.size());
  for (int pass = 0; pass < 2; ++pass) {
    const std::uint32_t begin = hull.size();
    for (int k = 0; k < count; ++k) {
      const rt::Vector3& p = points[static_cast<std::uint32_t>(pass == 0 ? k : count - 1 - k)];
      while (hull.size() >= begin + 2 && area(hull[hull.size() - 2], hull[hull.size() - 1], p) <= 0.0)
        hull.pop_back();
      (void)hull.push_back(p);
    }
    hull.pop_back();  // the other chain begins with it
  }
}

/// Height that the centre of mass gains on the way over the line through p and q, m.
double gain_over(const rt::Vector3& p, const rt::Vector3& q, const rt::Vector3& com) {
  const rt::Vector3 along = (1.0 / rt::norm(q - p)) * (q - p);
  const rt::Vector3 lever = (com - p) - rt::dot(com - p, along) * along;
  const double upright = std::sqrt(std::max(0.0, 1.0 - along.z * along.z));
  return rt::norm(lever) * upright - lever.z;
}

}  // namespace

void weigh_support(const PostureConfig& config, const Outline& outline, const Lifts& lifts,
                   const rt::Vector3& com_m, double mass_kg, Posture& posture) {
  double origin = lifts[0].lift_m;
  for (const Lift& lift : lifts) origin = std::max(origin, lift.lift_m);
  bool has_clearance = false;
  double clearance = 0.0;
  const Lift* end[kOutlineSlices][2]{};
  for (const Lift& lift : lifts) {
    const double gap = origin - lift.lift_m;
    const rt::VehiclePart part = outline[lift.slice].part;
    if (part == rt::VehiclePart::body) {
      clearance = has_clearance ? std::min(clearance, gap) : gap;
      has_clearance = true;
    }
    if (gap > config.touch_m) continue;
    ++posture.contacts;
    posture.parts |= 1u << static_cast<unsigned>(part);
    const Lift*(&ends)[2] = end[lift.slice];
    if (ends[0] == nullptr || lift.x_m < ends[0]->x_m) ends[0] = &lift;
    if (ends[1] == nullptr || lift.x_m > ends[1]->x_m) ends[1] = &lift;
  }
  Corners corners;
  for (const auto& ends : end) {
    for (const Lift* lift : ends)
      if (lift != nullptr) (void)corners.push_back({lift->x_m, lift->y_m, lift->ground_m - origin});
  }
  for (std::uint32_t k = 1; k < corners.size(); ++k) {
    for (std::uint32_t l = k; l > 0 && before(corners[l], corners[l - 1]); --l)
      std::swap(corners[l], corners[l - 1]);
  }
  rt::FixedVector<rt::Vector3, 2 * kMostCorners> hull;
  hull_of(corners, hull);
  double margin = 1e6;
  double gain = 1e6;
  for (std::uint32_t k = 0; k < hull.size(); ++k) {
    const rt::Vector3& p = hull[k];
    const rt::Vector3& q = hull[(k + 1) % hull.size()];
    const double length = std::sqrt((q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y));
    if (!(length > 1e-9)) continue;
    margin = std::min(margin, area(p, q, com_m) / length);
    gain = std::min(gain, gain_over(p, q, com_m));
  }
  posture.height_m = origin;
  posture.clearance_m = clearance;
  const bool polygon = hull.size() >= 3 && margin < 1e6;
  posture.margin_m = polygon ? margin : 0.0;
  posture.tip_energy_j = polygon && margin > 0.0 ? mass_kg * config.gravity_m_s2 * gain : 0.0;
}

}  // namespace sortie::planner
