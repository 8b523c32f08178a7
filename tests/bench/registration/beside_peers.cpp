// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/pcl_peers.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_sets.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {
namespace {

constexpr std::uint32_t kReturns = 2048;
constexpr int kScansOfHall = 10;

struct PeerRounds {
  Rounds ms, error_mm, error_deg, map_ms;
  int right{};

  void add(const PoseError& error, double step_ms) {
    ms.add(step_ms);
    error_mm.add(1e3 * error.move_m);
    error_deg.add(error.turn_deg);
    right += error.within(0.02, 0.2) ? 1 : 0;
  }
};

void print(const char* set, const char* who, const PeerRounds& theirs, const PeerRounds& ours) {
  std::printf(
      "| %s | %s | %zu | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f | %.0f %% | %.1f | %.0f | %.3f | %.2f |\n",
      set, who, theirs.ms.size(), theirs.ms.median(), theirs.ms.quantile(0.99), theirs.ms.high(),
      theirs.ms.median() / ours.ms.median(), theirs.ms.quantile(0.99) / ours.ms.quantile(0.99),
      theirs.ms.high() / theirs.ms.median(), 100.0 * theirs.right / static_cast<double>(theirs.ms.size()),
      theirs.error_mm.median(), theirs.error_mm.quantile(0.99), theirs.error_deg.median(),
      theirs.map_ms.median());
  std::fflush(stdout);
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

void compare(const char* name, const std::vector<MapAndScans>& sets) {
  mapping::RegistrationConfig config;
  config.returns = kReturns;
  PeerRounds ours;
  PeerRounds theirs[kPclPeers];
  for (const MapAndScans& set : sets) {
    const auto map = map_of(set, config);
    std::unique_ptr<PclPeers> peers;
    if (has_pcl_registration()) peers = std::make_unique<PclPeers>(points_of(set.map));
    for (std::size_t i = 0; i < set.scans.size(); ++i) {
      const PlacedScan& scan = set.scans[i];
      const MatchedStep step = matched_step(*map, scan.points, set.starts[i], 0.0);
      ours.add(pose_error(step.match.pose, scan.pose), step.ms);
      for (int peer = 0; peers != nullptr && peer < kPclPeers; ++peer) {
        const PclResult result = peers->align(peer, map->registration.sample(), set.starts[i]);
        theirs[peer].add(pose_error(result.pose, scan.pose), result.ms);
      }
    }
    for (int peer = 0; peers != nullptr && peer < kPclPeers; ++peer)
      theirs[peer].map_ms.add(peers->prepared_ms()[static_cast<std::size_t>(peer)]);
    for (const PlacedScan& scan : set.scans) {  // last: it changes the map
      (void)map->registration.take(scan.points);
      const double begin = step_cpu_ms();
      map->registration.insert(scan.pose);
      ours.map_ms.add(step_cpu_ms() - begin);
    }
  }
  print(name, "ours", ours, ours);
  for (int peer = 0; has_pcl_registration() && peer < kPclPeers; ++peer)
    print(name, kPclPeerNames[peer], theirs[peer], ours);
}

}  // namespace

void registration_beside_peers(const RegistrationSettings& settings) {
  std::printf(
      "\nStep: from %u returns to the pose; ours with covariance and the look along the rays. Map: keeping "
      "it up with a scan "
      "(ours), making what the peer knows of it (theirs).\n\n"
      "| set, start off by | who | n | step ms median | p99 | max | median of ours | p99 of ours | max of "
      "own "
      "median | within 2 cm, 0.2 deg | mm median | mm p99 | deg median | map ms |\n"
      "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
      kReturns);
  const int halls = std::max(1, (settings.cases > 0 ? settings.cases : 100) / kScansOfHall);
  const StartError near{0.2, 5 * M_PI / 180, false};
  const StartError far{0.5, 15 * M_PI / 180, false};
  compare("halls, 0.2 m 5 deg", hall_set(halls, kScansOfHall, near, settings.seed));
  compare("halls, 0.5 m 15 deg", hall_set(halls, kScansOfHall, far, settings.seed));
  const auto recorded = recorded_set(settings.data, near, settings.seed);
  if (recorded.empty()) {
    std::puts("\nskipped: the recorded drive is not there");
  } else {
    compare("recorded, 0.2 m 5 deg", recorded);
    compare("recorded, 0.5 m 15 deg", recorded_set(settings.data, far, settings.seed));
  }
  if (!has_pcl_registration())
    std::puts("\nskipped: PCL was not there when this was built; apt-get install libpcl-dev");
}

}  // namespace sortie::bench
