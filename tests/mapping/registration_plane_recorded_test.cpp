// SPDX-License-Identifier: BSD-3-Clause
// Recorded drives with a lidar of one row and wheels, against relations that were measured by hand.
#include <catch2/catch.hpp>

#include "tests/mapping/planar_follower.hpp"

using namespace sortie;

TEST_CASE(
    "a drive through a building is followed in the plane, and its relations are those that were measured",
    "[heavy]") {
  const auto scans = tests::read_planar_drive(SORTIE_DATA_DIR "/radish_2d/aces.clf", 50.0, true);
  const auto relations = tests::read_relations(SORTIE_DATA_DIR "/radish_2d/aces.relations");
  if (scans.empty() || relations.empty()) {
    WARN("skipped: no recorded drive in " SORTIE_DATA_DIR);
    return;
  }
  const tests::Followed followed = tests::follow_wheels(scans, 0.02);
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
