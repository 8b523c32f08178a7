// SPDX-License-Identifier: BSD-3-Clause
// Recorded drives with a lidar of one row (radish_2d), and poses measured against relations between them.
// Small readers; for tests and measurements only.
#pragma once

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "mapping/registration/level_pose.hpp"
#include "rt/samples.hpp"

namespace sortie::tests {

/// One row FLASER: returns below `max_range_m`, and the pose of the wheels at its stamp, from the rows ODOM
/// before and after.
struct PlanarScan {
  rt::Nanoseconds stamp_ns{};
  mapping::RigidPose odometry;
  std::vector<rt::ScanPoint> points;

  rt::PointScan view() const {
    rt::PointScan scan;
    scan.header.stamp_ns = stamp_ns;
    scan.header.points = static_cast<std::uint32_t>(points.size());
    scan.points = points.data();
    return scan;
  }
};

inline rt::Nanoseconds stamp_of(double seconds) {
  return std::llround(seconds * 1e6) * rt::kNanosecondsPerMicrosecond;
}

inline mapping::RigidPose planar_pose(double x_m, double y_m, double yaw_rad) {
  return {{x_m, y_m, 0.0}, rt::exp_rotation({0.0, 0.0, yaw_rad})};
}

/// Between the two of `poses` about a stamp, along a straight line and an even turn.
inline mapping::RigidPose pose_between(const std::map<rt::Nanoseconds, mapping::RigidPose>& poses,
                                       rt::Nanoseconds stamp_ns) {
  const auto next = poses.lower_bound(stamp_ns);
  if (next == poses.begin()) return next->second;
  const auto before = std::prev(next);
  if (next == poses.end()) return before->second;
  const double share =
      static_cast<double>(stamp_ns - before->first) / static_cast<double>(next->first - before->first);
  return {before->second.p + share * (next->second.p - before->second.p),
          rt::slerp(before->second.q, next->second.q, share)};
}

/// All scans of a CARMEN log, 180 degrees ahead; empty where it is not there. `by_stamp`: the wheels' pose is
/// that at the scan's stamp between the rows ODOM; else the one in the scan's own row, for logs whose stamps
/// come in bursts.
inline std::vector<PlanarScan> read_planar_drive(const std::string& path, double max_range_m, bool by_stamp) {
  std::ifstream file(path);
  std::vector<PlanarScan> scans;
  std::map<rt::Nanoseconds, mapping::RigidPose> wheels;
  std::string line, name;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::size_t count = 0;
    double x[6]{}, stamp = 0.0;
    row >> name;
    if (name == "ODOM" && row >> x[0] >> x[1] >> x[2] >> x[3] >> x[4] >> x[5] >> stamp)
      wheels[stamp_of(stamp)] = planar_pose(x[0], x[1], x[2]);
    if (name != "FLASER" || !(row >> count)) continue;
    PlanarScan scan;
    for (std::size_t i = 0; i < count; ++i) {
      double range = 0.0;
      row >> range;
      const double step = M_PI / static_cast<double>(count % 2 == 1 ? count - 1 : count);
      const double turn = -0.5 * M_PI + step * static_cast<double>(i);
      if (range > 0.0 && range < max_range_m)
        scan.points.push_back({static_cast<float>(range * std::cos(turn)),
                               static_cast<float>(range * std::sin(turn)), 0.0f, 0, 0});
    }
    if (!(row >> x[0] >> x[1] >> x[2] >> x[3] >> x[4] >> x[5] >> stamp)) continue;
    scan.stamp_ns = stamp_of(stamp);
    scan.odometry = planar_pose(x[3], x[4], x[5]);
    scans.push_back(std::move(scan));
  }
  for (PlanarScan& scan : scans) {
    if (by_stamp) scan.odometry = pose_between(wheels, scan.stamp_ns);
  }
  return scans;
}

/// The pose at one stamp as seen from that at another, by hand (Kuemmerle et al. 2009).
struct PlanarRelation {
  rt::Nanoseconds from_ns{}, to_ns{};
  mapping::RigidPose seen;
};

inline std::vector<PlanarRelation> read_relations(const std::string& path) {
  std::ifstream file(path);
  std::vector<PlanarRelation> out;
  double t[2], p[3], turn[3];
  while (file >> t[0] >> t[1] >> p[0] >> p[1] >> p[2] >> turn[0] >> turn[1] >> turn[2])
    out.push_back({stamp_of(t[0]), stamp_of(t[1]), planar_pose(p[0], p[1], turn[2])});
  return out;
}

/// Absolute errors of relations, as the benchmark counts them: means over all that have both poses.
struct RelationErrors {
  std::size_t count{}, missing{};
  double mean_m{}, mean_deg{};
  double largest_m{}, largest_deg{};
};

/// Of relations not longer than `longest_ns` in time.
inline RelationErrors errors_of(const std::vector<PlanarRelation>& relations,
                                const std::map<rt::Nanoseconds, mapping::RigidPose>& poses,
                                rt::Nanoseconds shortest_ns = 0,
                                rt::Nanoseconds longest_ns = rt::Nanoseconds{1} << 60) {
  RelationErrors errors;
  const auto between = [](const mapping::RigidPose& a, const mapping::RigidPose& b) {
    return mapping::RigidPose{rt::rotate_back(a.q, b.p - a.p), rt::conjugate(a.q) * b.q};
  };
  for (const PlanarRelation& relation : relations) {
    const rt::Nanoseconds span = std::abs(relation.to_ns - relation.from_ns);
    if (span < shortest_ns || span >= longest_ns) continue;
    const auto from = poses.find(relation.from_ns), to = poses.find(relation.to_ns);
    if (from == poses.end() || to == poses.end()) {
      ++errors.missing;
      continue;
    }
    const mapping::RigidPose off = between(relation.seen, between(from->second, to->second));
    const double m = rt::norm(off.p), deg = rt::norm(rt::log_rotation(off.q)) * 180.0 / M_PI;
    ++errors.count;
    errors.mean_m += m;
    errors.mean_deg += deg;
    errors.largest_m = std::max(errors.largest_m, m);
    errors.largest_deg = std::max(errors.largest_deg, deg);
  }
  if (errors.count > 0) {
    errors.mean_m /= static_cast<double>(errors.count);
    errors.mean_deg /= static_cast<double>(errors.count);
  }
  return errors;
}

}  // namespace sortie::tests
