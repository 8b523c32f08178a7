// SPDX-License-Identifier: BSD-3-Clause
// Missions with and without a heading that follows what rest teaches, over many seeds.
#pragma once

#include <catch2/catch.hpp>
#include <iostream>

#include "tests/estimators/standing_mission.hpp"

namespace sortie::estimators::test {

/// Root mean squares over the seeds, with or without a heading that follows what rest teaches. Every second
/// of standing is checked.
inline StandingErrors mean_of(StandingMission mission, std::uint32_t seeds, bool follows) {
  AttitudeConfig config;
  config.heading_follows_bias = follows;
  StandingErrors mean;
  for (mission.seed = 1; mission.seed <= seeds; ++mission.seed) {
    const StandingErrors one = StandingDrive(mission, config).run();
    INFO("seed " << mission.seed << ", instability " << mission.instability << ", follows " << follows);
    CHECK(one.second < 0.05);
    mean.end += one.end * one.end / seeds;
    mean.along += one.along * one.along / seeds;
    mean.second = std::max(mean.second, one.second);
  }
  return {std::sqrt(mean.end), std::sqrt(mean.along), mean.second};
}

/// Prints both; missions that follow may not end worse.
inline void compare(const char* name, const StandingMission& mission, std::uint32_t seeds) {
  const StandingErrors with = mean_of(mission, seeds, true);
  const StandingErrors without = mean_of(mission, seeds, false);
  std::clog << name << ", bias instability x " << mission.instability << ": heading at the end " << with.end
            << " deg (without following " << without.end << "), along the way " << with.along << " ("
            << without.along << "); standing " << with.second << " deg in a second\n";
  INFO(name << ", instability " << mission.instability << ", seeds 1 to " << seeds);
  CHECK(with.end <= without.end);
}

}  // namespace sortie::estimators::test
