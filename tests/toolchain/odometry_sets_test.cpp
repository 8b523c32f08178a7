// SPDX-License-Identifier: BSD-3-Clause
// Sets of samples as a slower sensor had sent them.
#include "toolchain/bench/odometry_sets.hpp"

#include <catch2/catch.hpp>

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;

TEST_CASE("the mean of thinned samples is over the readings that are there") {
  OdometrySet set;
  set.rate_hz = 100;
  for (std::uint32_t i = 0; i < 9; ++i) {
    rt::ImuSample sample;
    sample.stamp_ns = i;
    // The first three whole, then rates alone but for one force, then rates alone.
    sample.flags = rt::kImuGyr | (i < 3 || i == 4 ? +rt::kImuAcc : 0u);
    sample.gyr_rad_s[0] = 1.0 + i;
    if ((sample.flags & rt::kImuAcc) != 0) sample.acc_m_s2[2] = 9.0 + i % 3;
    set.events.push_back({i, OdometryEvent::Kind::imu, i});
    set.imu.push_back(sample);
  }
  const OdometrySet slow = thinned(set, 3);
  REQUIRE(slow.imu.size() == 3);
  CHECK(slow.imu[0].acc_m_s2[2] == Approx(10.0));
  CHECK(slow.imu[1].acc_m_s2[2] == Approx(10.0));  // the one that was there
  CHECK((slow.imu[1].flags & rt::kImuAcc) != 0);
  CHECK((slow.imu[2].flags & rt::kImuAcc) == 0);
  CHECK(slow.imu[0].gyr_rad_s[0] == Approx(2.0));
  CHECK(slow.imu[2].gyr_rad_s[0] == Approx(8.0));
}
