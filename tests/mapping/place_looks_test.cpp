// SPDX-License-Identifier: BSD-3-Clause
// Two searches that find a lost robot, and when they are believed.
#include "mapping/registration/place_looks.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace {
using namespace sortie;
using mapping::JudgedPlace;
using mapping::PlaceLooks;
using mapping::PlaceLooksConfig;
using mapping::RigidPose;

const RigidPose kTMapOdom{{30, -4, 2}, rt::exp_rotation({0, 0, 1.2})};

/// A search that finds the odometry where `T_map_odom` says.
JudgedPlace found_at(const RigidPose& T_odom_sensor, bool sure, const RigidPose& T_map_odom = kTMapOdom) {
  JudgedPlace found;
  found.verdict = mapping::RelocateVerdict::placed;
  found.T_map_sensor = mapping::after(T_map_odom, T_odom_sensor);
  found.sure = sure;
  return found;
}
RigidPose at(double x_m, double turn_rad = 0.4) {
  return {{x_m, 1, 0.5}, rt::exp_rotation({0, 0, turn_rad})};
}

/// Whether a look at 0 and one `way_m` on are believed.
bool believed(double way_m, bool first_sure, bool second_sure, const PlaceLooksConfig& config = {}) {
  PlaceLooks looks(config);
  if (looks.take(found_at(at(0), first_sure), at(0))) return true;
  return looks.take(found_at(at(way_m, -2.0), second_sure), at(way_m, -2.0));
}
}  // namespace

TEST_CASE("Two looks that agree are believed two metres apart where both are sure, else six") {
  for (const bool first : {false, true}) {
    for (const bool second : {false, true}) {
      const double way_m = first && second ? 2.0 : 6.0;
      CAPTURE(first, second);
      CHECK(believed(way_m + 0.01, first, second));
      CHECK_FALSE(believed(way_m - 0.01, first, second));
    }
  }
  CHECK(believed(0.0, false, false, {0.0, 6.0}));       // one is enough
  CHECK_FALSE(believed(3.0, false, true, {4.0, 1.0}));  // what is not sure is not believed sooner
  CHECK(believed(4.1, false, true, {4.0, 1.0}));
}

TEST_CASE("A look that finds another place is the first look of that one") {
  const auto second_at = [](double move_m, double turn_rad) {
    PlaceLooks looks{{}};
    CHECK_FALSE(looks.take(found_at(at(100), true), at(100)));
    // Moved and turned at the robot, a hundred metres from the odometry's origin.
    JudgedPlace found = found_at(at(108), true);
    found.T_map_sensor.p = found.T_map_sensor.p + rt::Vector3{move_m, 0, 0};
    found.T_map_sensor.q = rt::exp_rotation({0, 0, turn_rad}) * found.T_map_sensor.q;
    const bool believed = looks.take(found, at(108));
    CHECK(looks.counts().disagreed == (believed ? 0u : 1u));
    CHECK(looks.counts().first_looks == (believed ? 1u : 2u));
    return believed;
  };
  CHECK(second_at(0.28, 0.0));
  CHECK(second_at(0.0, 0.049));
  CHECK_FALSE(second_at(0.32, 0.0));
  CHECK_FALSE(second_at(0.0, 0.051));
  CHECK_FALSE(second_at(0.0, 3.14159));
  PlaceLooks looks{{}};
  const RigidPose other{kTMapOdom.p + rt::Vector3{1, 0, 0}, kTMapOdom.q};
  CHECK_FALSE(looks.take(found_at(at(0), true), at(0)));
  CHECK_FALSE(looks.take(found_at(at(3), true, other), at(3)));
  CHECK_FALSE(looks.take(found_at(at(4), true, other), at(4)));  // a metre from the look that counts
  CHECK(looks.take(found_at(at(5.1), true, other), at(5.1)));
  CHECK_FALSE(looks.take(found_at(at(9), true, other), at(9)));  // the looks have begun anew
}

TEST_CASE("A sure look takes the place of one that is not, and is not replaced by one") {
  PlaceLooks looks{{}};
  CHECK_FALSE(looks.take(found_at(at(0), false), at(0)));
  CHECK_FALSE(looks.take(found_at(at(3), true), at(3)));   // now the one that counts
  CHECK_FALSE(looks.take(found_at(at(4), false), at(4)));  // goes by
  CHECK(looks.take(found_at(at(5.1), true), at(5.1)));
  CHECK(looks.counts().first_looks == 1);
  CHECK(looks.counts().disagreed == 0);
}
