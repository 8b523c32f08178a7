// SPDX-License-Identifier: BSD-3-Clause
// Recorded drives with a lidar of one row and wheels, against relations that were measured by hand.
#include <catch2/catch.hpp>

#include "mapping/registration/locator.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "tests/mapping/planar_drive.hpp"

using namespace sortie;

namespace {
/// As scene lidar_plane has it.
mapping::RegistrationConfig planar_scene() {
  mapping::RegistrationConfig config;
  config.planar = true;
  config.edge_m = 0.05;
  config.good_share = 0.95;
  config.most_crossed = 0.35;
  config.most_inside = 0.4;
  return config;
}

struct Followed {
  std::map<rt::Nanoseconds, mapping::RigidPose> poses;
  mapping::LocateCounts counts;
  std::size_t surfels{};
};

Followed follow_wheels(const std::vector<tests::PlanarScan>& scans, double sigma_turn_rad) {
  std::vector<std::byte> memory(std::size_t{48} << 20);
  rt::Arena arena(memory);
  mapping::Locator locator(planar_scene(), arena, {32'768, 512, 8});
  REQUIRE(arena.refused() == 0);
  Followed out;
  mapping::RigidPose last = scans.front().odometry;
  for (const tests::PlanarScan& scan : scans) {
    const mapping::RigidPose moved = mapping::after(mapping::inverse(last), scan.odometry);
    const mapping::OdometryHint hint{true, scan.odometry, 0.03 + 0.2 * rt::norm(moved.p),
                                     sigma_turn_rad + 0.3 * rt::norm(rt::log_rotation(moved.q))};
    const mapping::Located& located = locator.locate(scan.view(), hint);
    if (mapping::is_placed(located.verdict)) last = scan.odometry;
    out.poses[scan.stamp_ns] = located.T_map_sensor;
  }
  out.counts = locator.located().counts;
  out.surfels = locator.registration().layer(0).size();
  return out;
}
}  // namespace

TEST_CASE(
    "a drive through a building is followed in the plane, and its relations are those that were measured",
    "[heavy]") {
  const auto scans = tests::read_planar_drive(SORTIE_DATA_DIR "/radish_2d/aces.clf", 50.0, true);
  const auto relations = tests::read_relations(SORTIE_DATA_DIR "/radish_2d/aces.relations");
  if (scans.empty() || relations.empty()) {
    WARN("skipped: no recorded drive in " SORTIE_DATA_DIR);
    return;
  }
  const Followed followed = follow_wheels(scans, 0.02);
  const tests::RelationErrors all = tests::errors_of(relations, followed.poses);
  const tests::RelationErrors late =
      tests::errors_of(relations, followed.poses, 60 * rt::kNanosecondsPerSecond);
  INFO(all.mean_m << " m, " << all.mean_deg << " degrees over " << all.count << "; revisits " << late.mean_m
                  << " m, " << late.mean_deg << " degrees over " << late.count);
  CHECK(all.missing == 0);
  CHECK(all.mean_m < 0.040);
  CHECK(all.mean_deg < 0.40);
  CHECK(late.count > 80);
  CHECK(late.mean_m < 0.1);
  CHECK(followed.counts.accepted + 30 > followed.counts.in);
}

TEST_CASE("a drive that comes back to the same rooms for three quarters of an hour keeps one map of them",
          "[heavy]") {
  // Its stamps come in bursts: the wheels' pose is that of the scan's own row.
  const auto scans = tests::read_planar_drive(SORTIE_DATA_DIR "/radish_2d/intel.clf", 80.0, false);
  if (scans.empty()) {
    WARN("skipped: no recorded drive in " SORTIE_DATA_DIR);
    return;
  }
  const Followed followed = follow_wheels(scans, 0.02);
  INFO(followed.counts.accepted << " of " << followed.counts.in << ", " << followed.surfels << " surfels");
  CHECK(followed.counts.accepted > 97 * followed.counts.in / 100);
  CHECK(followed.surfels < 2300);  // twice that where a revisit lies beside what was there
}
