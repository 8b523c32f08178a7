// SPDX-License-Identifier: BSD-3-Clause
// Independent geometry for judging the simulated world: every solid as a set of half-spaces and a circle,
// libm trigonometry.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "drivers/scan_source.hpp"
#include "hil/world.hpp"

namespace sortie::hil::oracle {

/// Largest signed distance of a point to the half-spaces (and the circle) that bound a solid: negative
/// inside, 0 on the surface, positive outside. For a convex solid that is the distance to its surface
/// wherever a face is nearest.
inline double depth(const Solid& s, const Vec3& p) {
  const double dx = p.x - s.center_x_m;
  const double dy = p.y - s.center_y_m;
  const double angle = std::atan2(s.sin_yaw, s.cos_yaw);
  const double u = std::cos(angle) * dx + std::sin(angle) * dy;
  const double v = -std::sin(angle) * dx + std::cos(angle) * dy;
  double d = s.bottom_m - p.z;
  if (s.kind == SolidKind::cylinder) {
    d = std::max({d, std::sqrt(u * u + v * v) - s.half_x_m, p.z - s.top_m});
    return d;
  }
  d = std::max({d, u - s.half_x_m, -u - s.half_x_m, v - s.half_y_m, -v - s.half_y_m});
  if (s.kind == SolidKind::box) return std::max(d, p.z - s.top_m);
  const double rise = std::atan2(s.top_m - s.low_m, 2.0 * s.half_x_m);
  return std::max(d, std::cos(rise) * (p.z - s.low_m) - std::sin(rise) * (u + s.half_x_m));
}

/// Distance from a point to the nearest surface of the world, ground included, by asking every solid.
inline double surface_distance(const World& world, const Vec3& p) {
  double nearest = std::fabs(p.z);
  for (std::size_t i = 0; i < world.size(); ++i)
    nearest = std::min(nearest, std::fabs(depth(world.solid(i), p)));
  return nearest;
}

/// How deep a point is in the world: negative in something.
inline double world_depth(const World& world, const Vec3& p) {
  double d = p.z;
  for (std::size_t i = 0; i < world.size(); ++i) d = std::min(d, depth(world.solid(i), p));
  return d;
}

/// A sink that keeps every scan, and can refuse.
class KeepingSink final : public drivers::ScanSink {
 public:
  struct Scan {
    rt::ScanHeader header;
    std::vector<rt::ScanPoint> points;
  };

  rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override {
    ++reserved;
    if (refuse_reserve || open) return nullptr;
    open = true;
    buffer.resize(capacity);
    return buffer.data();
  }
  Status commit(const rt::ScanHeader& header) noexcept override {
    if (!open || header.points > buffer.size()) return Status::malformed;
    open = false;
    if (refuse_commit) return Status::full;
    scans.push_back({header, {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(header.points)}});
    return Status::ok;
  }
  void cancel() noexcept override { open = false; }

  std::vector<Scan> scans;
  std::vector<rt::ScanPoint> buffer;
  bool open{};
  bool refuse_reserve{};
  bool refuse_commit{};
  int reserved{};
};

}  // namespace sortie::hil::oracle
