// SPDX-License-Identifier: BSD-3-Clause
// The estimators take no memory from the heap after construction.
#include <catch2/catch.hpp>

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "rt/posix/heap_trap.hpp"

TEST_CASE("Attitude and odometry make no heap call after construction") {
  using namespace sortie;
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  estimators::Attitude attitude{estimators::AttitudeConfig{}};
  estimators::TrackOdometryConfig config;
  config.track_width_m = 0.4;
  config.obstacles = true;
  config.learn_steering = true;
  estimators::TrackOdometry odometry{config};
  std::uint64_t calls = 0;
  std::uint32_t refused = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 2000; ++i) {
      const rt::Nanoseconds now = i * 5 * rt::kNanosecondsPerMillisecond;
      rt::ImuSample imu{now, {0.01 * (i % 7), 0, 0.3}, {0.1, 0, 9.8}, rt::kImuGyr | rt::kImuAcc};
      if (i % 100 == 50) imu.gyr_rad_s[0] = 1e30;
      refused += attitude.update(imu) == Status::ok ? 0 : 1;
      refused += odometry.observe(attitude.estimate()) == Status::ok ? 0 : 1;
      odometry.feel(imu);
      odometry.set_flippers({0.5, 0.1 * (i % 5)});
      refused += odometry.update({now, 0.001 * i, 0.002 * i, 0}) == Status::ok ? 0 : 1;
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(refused == 20);
}
