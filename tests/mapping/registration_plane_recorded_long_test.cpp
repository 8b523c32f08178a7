// SPDX-License-Identifier: BSD-3-Clause
// The longest of the recorded drives with a lidar of one row.
#include <catch2/catch.hpp>

#include "tests/mapping/planar_follower.hpp"

using namespace sortie;

TEST_CASE("a drive that comes back to the same rooms for three quarters of an hour keeps one map of them") {
  // Its stamps come in bursts: the wheels' pose is that of the scan's own row.
  const auto scans = tests::read_planar_drive(SORTIE_DATA_DIR "/radish_2d/intel.clf", 80.0, false);
  if (scans.empty()) {
    WARN("skipped: no recorded drive in " SORTIE_DATA_DIR);
    return;
  }
  const tests::Followed followed = tests::follow_wheels(scans, 0.02);
  INFO(followed.counts.accepted << " of " << followed.counts.in << ", " << followed.surfels << " surfels");
  CHECK(followed.counts.accepted > 97 * followed.counts.in / 100);
  CHECK(followed.surfels < 2300);  // twice that where a revisit lies beside what was there
}
