// SPDX-License-Identifier: BSD-3-Clause
// An elevation map in double that keeps every return of every cell, has no window of its own, and asks every
// ray at every cell of its bounding box.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "mapping/elevation/elevation_map.hpp"
#include "mapping/elevation/elevation_units.hpp"

namespace sortie::tests {

/// An elevation map with its memory.
struct OwnedElevation {
  explicit OwnedElevation(const mapping::ElevationConfig& config)
      : memory(static_cast<std::size_t>(mapping::ElevationMap::memory_bytes(config)) + 4096),
        arena(memory),
        map(config, arena) {}
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ElevationMap map;
};

/// Points in the sensor's frame as a scan.
inline rt::PointScan scan_of(const std::vector<rt::ScanPoint>& points, rt::Nanoseconds stamp_ns) {
  rt::PointScan scan;
  scan.header.stamp_ns = stamp_ns;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

class ElevationTwin {
 public:
  struct Seen {
    double height_m;
    double variance_m2;
    double moved_m2;  // variance that motion had added by then
    unsigned flags;
  };
  struct Surface {
    double height_m;
    double variance_m2;
    unsigned flags;
  };
  struct Cell {
    std::vector<Seen> seen;
    double bound_m{std::numeric_limits<double>::infinity()};  // by rays that surely crossed it
    double least_m{std::numeric_limits<double>::infinity()};  // by those too that may have
  };
  using Place = std::pair<std::int64_t, std::int64_t>;

  explicit ElevationTwin(const mapping::ElevationConfig& config)
      : config_(config), edge_m_(config.cell_mm * 1e-3) {}

  void move(double variance_m2) { moved_m2_ += variance_m2; }
  /// Only cells of the window stay.
  void keep(const mapping::ElevationView& window) {
    low_[0] = window.low[0];
    low_[1] = window.low[1];
    std::erase_if(cells_,
                  [&](const auto& cell) { return !window.contains(cell.first.first, cell.first.second); });
  }
  void take(const rt::PointScan& scan, const mapping::SensorPose& pose) {
    for (std::uint32_t i = 0; i < scan.header.points; ++i) {
      const rt::ScanPoint& p = scan.points[i];
      const rt::Vector3 way =
          rt::rotate(pose.q_world_sensor,
                     {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)});
      const double range2 = rt::dot(way, way);
      const double range = std::sqrt(range2);
      if (range < config_.min_range_m || range > config_.max_range_m) continue;
      const double from[2] = {near(pose.p_world_sensor_m.x), near(pose.p_world_sensor_m.y)};
      const double along[2] = {middle(way.x), middle(way.y)};
      if (way.z < 0) pass(from, along, pose.p_world_sensor_m.z, way.z, std::hypot(way.x, way.y));
      const Place place{cell(from[0] + along[0]), cell(from[1] + along[1])};
      if (!inside(place)) continue;
      const double a = config_.noise_m;
      const double b = config_.noise_per_m;
      cells_[place].seen.push_back({pose.p_world_sensor_m.z + way.z, a * a + b * b * range2, moved_m2_,
                                    way.z > 0 ? mapping::kSeenFromBelow : mapping::kSeenFromAbove});
    }
  }

  const std::map<Place, Cell>& cells() const { return cells_; }

  /// All surfaces of a cell from all its returns; `shaky` where a decision hung on a millimetre.
  std::vector<Surface> surfaces(const Cell& cell, bool& shaky) const {
    shaky = false;
    std::vector<Surface> found;
    double moved = 0;
    for (const Seen& seen : cell.seen) {
      for (Surface& s : found) s.variance_m2 += seen.moved_m2 - moved;
      moved = seen.moved_m2;
      std::size_t nearest = 0;
      for (std::size_t i = 1; i < found.size(); ++i)
        if (apart(found[i], seen) < apart(found[nearest], seen)) nearest = i;
      for (std::size_t i = 0; i < found.size(); ++i)
        if (i != nearest && std::fabs(apart(found[i], seen) - apart(found[nearest], seen)) < 2e-3 &&
            apart(found[i], seen) < 0.1)
          shaky = true;
      const double gate = found.empty() ? 0 : gate_m(found[nearest].variance_m2 + seen.variance_m2);
      if (!found.empty() && std::fabs(apart(found[nearest], seen) - gate) < 1e-3 + 0.02 * gate) shaky = true;
      if (!found.empty() && apart(found[nearest], seen) <= gate) {
        found[nearest] = both(found[nearest], {seen.height_m, seen.variance_m2, seen.flags});
      } else {
        found.push_back({seen.height_m, seen.variance_m2, seen.flags});
      }
      std::sort(found.begin(), found.end(),
                [](const Surface& p, const Surface& q) { return p.height_m < q.height_m; });
      for (std::size_t i = 0; i + 1 < found.size(); ++i) {
        const double gap = found[i + 1].height_m - found[i].height_m;
        if (std::fabs(gap - 0.5 * config_.join_m) < 1e-3) shaky = true;
        if (gap > 0.5 * config_.join_m) continue;
        const double low_m = found[i].height_m;
        found[i] = both(found[i], found[i + 1]);
        if (found[i].flags == mapping::kSeenFromBelow) found[i].height_m = low_m;
        found.erase(found.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        break;
      }
      if (found.size() > mapping::ElevationCell::kSurfaces) {
        shaky = true;  // judged by rules of their own
        found.erase(found.begin() + 1);
      }
    }
    for (Surface& s : found) s.variance_m2 += moved_m2_ - moved;
    return found;
  }

 private:
  static double near(double x) { return std::round(x * mapping::kGroundUnits) / mapping::kGroundUnits; }
  static double middle(double x) {
    return (std::floor(x * mapping::kGroundUnits) + 0.5) / mapping::kGroundUnits;
  }
  std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x / edge_m_)); }
  bool inside(const Place& p) const {
    return p.first >= low_[0] && p.first < low_[0] + config_.size && p.second >= low_[1] &&
           p.second < low_[1] + config_.size;
  }
  static double apart(const Surface& s, const Seen& seen) { return std::fabs(s.height_m - seen.height_m); }
  double gate_m(double variance_m2) const {
    return std::max(config_.join_m, std::min(config_.most_join_m, 3 * std::sqrt(variance_m2)));
  }
  Surface both(const Surface& a, const Surface& b) const {
    const double wa = 1 / a.variance_m2;
    const double wb = 1 / b.variance_m2;
    const double least = config_.least_sigma_m * config_.least_sigma_m;
    return {(wa * a.height_m + wb * b.height_m) / (wa + wb), std::max(least, 1 / (wa + wb)),
            a.flags | b.flags};
  }

  // Bounds every cell that the ray crosses whole before it ends or leaves the window.
  void pass(const double (&from)[2], const double (&way)[2], double from_z, double way_z, double length) {
    double end = std::min(1 - config_.ray_short_m / length, config_.bound_reach_m / -way_z);
    if (end <= 0) return;
    for (int a = 0; a < 2; ++a) {
      const double border = edge_m_ * static_cast<double>(low_[a] + (way[a] > 0 ? config_.size : 0));
      end = std::min(end, (border - from[a]) / way[a]);
    }
    const auto low = [&](int a) { return cell(std::min(from[a], from[a] + end * way[a])) - 1; };
    const auto high = [&](int a) { return cell(std::max(from[a], from[a] + end * way[a])) + 1; };
    for (std::int64_t y = low(1); y <= high(1); ++y) {
      for (std::int64_t x = low(0); x <= high(0); ++x) {
        const std::int64_t c[2] = {x, y};
        double in = 0;
        double out = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 2; ++a) {
          const double t1 = (edge_m_ * static_cast<double>(c[a]) - from[a]) / way[a];
          const double t2 = (edge_m_ * static_cast<double>(c[a] + 1) - from[a]) / way[a];
          in = std::max(in, std::min(t1, t2));
          out = std::min(out, std::max(t1, t2));
        }
        const double tie = 1e-4 / length;
        if (out < in - tie || out > end + tie || !inside({x, y})) continue;
        Cell& cell = cells_[{x, y}];
        const double at_m = from_z + in * way_z;
        cell.least_m = std::min(cell.least_m, at_m);
        if (out > in + tie && out < end - tie) cell.bound_m = std::min(cell.bound_m, at_m);
      }
    }
  }

  mapping::ElevationConfig config_;
  double edge_m_;
  double moved_m2_{};
  std::int64_t low_[2]{};
  std::map<Place, Cell> cells_;
};

}  // namespace sortie::tests
