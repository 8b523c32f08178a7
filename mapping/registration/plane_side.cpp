// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/registration/plane_pose.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kFamilyCosine = 0.99756;  ///< 4 degrees

/// A total order of planes that differ in anything, largest first.
bool before(const Plane& a, const Plane& b) {
  if (a.area_m2 != b.area_m2) return a.area_m2 > b.area_m2;
  const auto others = [](const Plane& p) {
    return std::to_array({p.offset_m, p.normal.x, p.normal.y, p.normal.z, p.centroid_m.x, p.centroid_m.y,
                          p.centroid_m.z, p.axis_u.x, p.axis_u.y, p.axis_u.z, p.least_m[0], p.least_m[1],
                          p.most_m[0], p.most_m[1], p.sigma_offset_m, p.sigma_tilt_rad[0],
                          p.sigma_tilt_rad[1], static_cast<double>(p.id)});
  };
  return others(a) < others(b);
}
}  // namespace

void PlaneSide::take(const PlaneSet& planes) {
  size_ = planes.size();
  for (std::uint32_t i = 0; i < size_; ++i) given_[i] = static_cast<std::uint16_t>(i);
  std::sort(given_, given_ + size_,
            [&planes](std::uint16_t a, std::uint16_t b) { return before(planes[a], planes[b]); });
  for (std::uint32_t i = 0; i < size_; ++i) plane_[i] = planes[given_[i]];
  find_box();
  find_families();
  take_normals();
  for (std::uint32_t i = 0; i < size_; ++i) {
    log_sigma_[i] = rt::log(plane_[i].sigma_offset_m);
    log_extent_[i] = rt::log(std::max(1.0, extent_m(plane_[i].normal)));
  }
}

void PlaneSide::take_normals() {
  for (std::uint32_t i = 0; i < size_; ++i) {
    normal_[0][i] = plane_[i].normal.x;
    normal_[1][i] = plane_[i].normal.y;
    normal_[2][i] = plane_[i].normal.z;
  }
}

void PlaneSide::mirror(const PlaneSide& other, const rt::Vector3& axis) {
  size_ = other.size_;
  families_ = 0;
  for (std::uint32_t i = 0; i < size_; ++i) {
    const Plane& from = other.plane_[i];
    Plane& to = plane_[i];
    to = from;
    to.normal = mirrored(from.normal, axis);
    to.axis_u = mirrored(from.axis_u, axis);
    to.centroid_m = other.middle_ + mirrored(from.centroid_m - other.middle_, axis);
    to.offset_m = rt::dot(to.normal, to.centroid_m);
    to.least_m[1] = -from.most_m[1];  // v, their vector product, turns round
    to.most_m[1] = -from.least_m[1];
    given_[i] = other.given_[i];
    family_[i] = kNoFamily;
    log_sigma_[i] = other.log_sigma_[i];
    log_extent_[i] = other.log_extent_[i];
  }
  take_normals();
  find_box();
}

void PlaneSide::find_box() {
  rt::Vector3 least;
  rt::Vector3 most;
  for (std::uint32_t i = 0; i < size_; ++i) {
    const Plane& p = plane_[i];
    const rt::Vector3 v = p.axis_v();
    const auto reach = [&p](double u_part, double v_part, double sign) {
      const double sides[2] = {(u_part * sign < 0.0 ? -p.least_m[0] : p.most_m[0]) * std::fabs(u_part),
                               (v_part * sign < 0.0 ? -p.least_m[1] : p.most_m[1]) * std::fabs(v_part)};
      return sides[0] + sides[1];
    };
    const rt::Vector3 low{p.centroid_m.x - reach(p.axis_u.x, v.x, -1),
                          p.centroid_m.y - reach(p.axis_u.y, v.y, -1),
                          p.centroid_m.z - reach(p.axis_u.z, v.z, -1)};
    const rt::Vector3 high{p.centroid_m.x + reach(p.axis_u.x, v.x, 1),
                           p.centroid_m.y + reach(p.axis_u.y, v.y, 1),
                           p.centroid_m.z + reach(p.axis_u.z, v.z, 1)};
    least = i == 0
                ? low
                : rt::Vector3{std::min(least.x, low.x), std::min(least.y, low.y), std::min(least.z, low.z)};
    most = i == 0 ? high
                  : rt::Vector3{std::max(most.x, high.x), std::max(most.y, high.y), std::max(most.z, high.z)};
  }
  middle_ = 0.5 * (least + most);
  half_ = 0.5 * (most - least);
}

bool PlaneSide::covers(const rt::Vector3& x_m, double margin_m) const {
  const rt::Vector3 d = x_m - middle_;
  return std::fabs(d.x) <= half_.x + margin_m && std::fabs(d.y) <= half_.y + margin_m &&
         std::fabs(d.z) <= half_.z + margin_m;
}

double PlaneSide::extent_m(const rt::Vector3& direction) const {
  return 2.0 * (std::fabs(direction.x) * half_.x + std::fabs(direction.y) * half_.y +
                std::fabs(direction.z) * half_.z);
}

std::uint32_t PlaneSide::near_normals(const rt::Vector3& n, double least_cosine, bool signs,
                                      std::uint16_t* which) const {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < size_; ++i) {  // no branch: three out of four are not near
    const double along = n.x * normal_[0][i] + n.y * normal_[1][i] + n.z * normal_[2][i];
    which[count] = static_cast<std::uint16_t>(i);
    count += static_cast<std::uint32_t>((signs ? along : std::fabs(along)) >= least_cosine);
  }
  return count;
}

void PlaneSide::find_families() {
  families_ = 0;
  rt::Vector3 founder[kMostFamilies];
  rt::Vector3 sum[kMostFamilies];
  for (std::uint32_t i = 0; i < size_; ++i) {
    const rt::Vector3& n = plane_[i].normal;
    family_[i] = kNoFamily;
    for (std::uint32_t f = 0; f < families_; ++f) {
      const double along = rt::dot(n, founder[f]);
      if (std::fabs(along) < kFamilyCosine) continue;
      family_[i] = static_cast<std::uint8_t>(f);
      sum[f] = sum[f] + ((along < 0.0 ? -1.0 : 1.0) * std::min(plane_[i].area_m2, 50.0)) * n;
      break;
    }
    if (family_[i] != kNoFamily || families_ == kMostFamilies) continue;
    family_[i] = static_cast<std::uint8_t>(families_);
    founder[families_] = n;
    sum[families_] = (std::min(plane_[i].area_m2, 50.0) + 1e-6) * n;
    ++families_;
  }
  for (std::uint32_t f = 0; f < families_; ++f) axis_[f] = (1.0 / rt::norm(sum[f])) * sum[f];
}

}  // namespace sortie::mapping
