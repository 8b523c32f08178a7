// SPDX-License-Identifier: BSD-3-Clause
// The whole step beside PCL's registrations: the same map, returns and starts.
#include <algorithm>
#include <cmath>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_peers.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
namespace {

constexpr std::uint32_t kReturns = 2048;
constexpr int kScansOfHall = 10;

struct PeerRounds {
  Rounds ms, mm, deg, map_ms;
  int right{};

  void add(const PoseError& error, double step_ms) {
    ms.add(step_ms);
    mm.add(1e3 * error.move_m);
    deg.add(error.turn_deg);
    right += error.within(0.02, 0.2) ? 1 : 0;
  }
};

Json row(const std::string& set, const std::string& who, const PeerRounds& theirs) {
  return {set,
          who,
          theirs.ms.size(),
          decimals(theirs.ms.median(), 2),
          decimals(theirs.ms.quantile(0.99), 2),
          decimals(theirs.ms.high(), 2),
          decimals(theirs.ms.high() / theirs.ms.median(), 1),
          decimals(100.0 * theirs.right / static_cast<double>(theirs.ms.size()), 0) + " %",
          decimals(theirs.mm.median(), 1),
          decimals(theirs.mm.quantile(0.99), 0),
          decimals(theirs.deg.median(), 3),
          decimals(theirs.map_ms.median(), 2)};
}

Figure step_figure(const std::string& set, const PeerRounds& ours, int peer, const PeerRounds& theirs) {
  Figure figure;
  figure.group = "peers";
  figure.what = "whole step, " + set;
  figure.unit = "ms";
  figure.n = ours.ms.size();
  figure.ours = spread(ours.ms);
  figure.peer = kScanPeerNames[peer];
  figure.theirs = spread(theirs.ms);
  const Rounds share = ratio(ours.ms, theirs.ms);
  figure.ratio = spread(share);
  if (peer == kVoxelGicp) set_goal(figure, "a quarter at most", share.median() <= 0.25);
  return figure;
}

std::vector<rt::Vector3> points_of(const std::vector<PlacedScan>& scans) {
  std::vector<rt::Vector3> points;
  for (const PlacedScan& scan : scans) {
    for (const rt::ScanPoint& p : scan.points) {
      const rt::Vector3 v{static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
      if (rt::norm(v) < 60.0) points.push_back(scan.pose.p + rt::rotate(scan.pose.q, v));
    }
  }
  return points;
}

void compare(Report& report, Json& rows, const std::string& name, const std::vector<MapAndScans>& sets) {
  mapping::RegistrationConfig config;
  config.returns = kReturns;
  PeerRounds ours, alone;
  PeerRounds theirs[kScanPeers];
  for (const MapAndScans& set : sets) {
    const auto map = map_of(set, config);
    std::unique_ptr<ScanPeers> peers;
    if (has_pcl()) peers = std::make_unique<ScanPeers>(points_of(set.map));
    for (std::size_t i = 0; i < set.scans.size(); ++i) {
      const PlacedScan& scan = set.scans[i];
      for (const Known known : {Known::alone, Known::odometry}) {
        const MatchedStep step = matched_step(*map, scan.points, set.starts[i], known);
        (known == Known::alone ? alone : ours).add(pose_error(step.match.pose, scan.pose), step.ms);
      }
      for (int peer = 0; peers != nullptr && peer < kScanPeers; ++peer) {
        const PeerResult result = peers->align(peer, map->registration.sample(), set.starts[i]);
        theirs[peer].add(pose_error(result.pose, scan.pose), result.ms);
      }
    }
    for (int peer = 0; peers != nullptr && peer < kScanPeers; ++peer)
      theirs[peer].map_ms.add(peers->prepared_ms()[static_cast<std::size_t>(peer)]);
    for (const PlacedScan& scan : set.scans) {  // last: it changes the map
      (void)map->registration.take(scan.points);
      const double begin = step_cpu_ms();
      map->registration.insert(scan.pose);
      ours.map_ms.add(step_cpu_ms() - begin);
      alone.map_ms.add(ours.map_ms.values().back());
    }
  }
  rows.push_back(row(name, "ours", ours));
  rows.push_back(row(name, "ours, no odometry", alone));
  for (int peer = 0; has_pcl() && peer < kScanPeers; ++peer) {
    rows.push_back(row(name, kScanPeerNames[peer], theirs[peer]));
    report.add(step_figure(name, ours, peer, theirs[peer]));
  }
}

}  // namespace

void measure_registration_peers(const RegistrationSettings& settings, Report& report) {
  const int halls = std::max(1, settings.cases_or(100) / kScansOfHall);
  const StartError near{0.2, 5 * M_PI / 180, false};
  const StartError far{0.5, 15 * M_PI / 180, false};
  Json rows = Json::array();
  compare(report, rows, "halls, 0.2 m 5 deg off", hall_set(halls, kScansOfHall, near, settings.seed));
  compare(report, rows, "halls, 0.5 m 15 deg off", hall_set(halls, kScansOfHall, far, settings.seed));
  const auto recorded = recorded_set(settings.data, near, settings.seed);
  if (recorded.empty()) {
    report.skip("the recorded drive", "lidar_os64 is not in " + settings.data);
  } else {
    compare(report, rows, "recorded drive, 0.2 m 5 deg off", recorded);
    compare(report, rows, "recorded drive, 0.5 m 15 deg off",
            recorded_set(settings.data, far, settings.seed));
  }
  report.add_table("peers",
                   {"start", "who", "n", "step ms median", "p99", "max", "max of own median",
                    "within 2 cm, 0.2 deg", "mm median", "mm p99", "deg median", "map ms"},
                   rows);
  report.note(
      "peers",
      "Step: from the returns to the pose; ours has the covariance and the look along the rays in it, with "
      "odometry that is good to 2 m and 2 rad, or with none: then other poses are tried that may do as well. "
      "It keeps " +
          std::to_string(kReturns) +
          " returns itself, which are then the peers'. Map: ours, a scan that goes into it; theirs, "
          "what they know of it (trees, normals, covariances, cells), made before their clock starts. "
          "On the recorded drive errors below 2 cm are those of its reference.");
  if (!has_pcl()) report.skip("PCL", "not there when this was built; apt-get install libpcl-dev");
}

}  // namespace sortie::bench
