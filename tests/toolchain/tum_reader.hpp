// SPDX-License-Identifier: BSD-3-Clause
// Reads back what is exported as a TUM trajectory, and a published one.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "firmware_like/log/timed_pose.hpp"
#include "toolchain/import/text_file.hpp"

namespace sortie::testing {

/// Rows of `t tx ty tz qx qy qz qw`, stamps to the nanosecond; '#' starts a comment.
inline firmware::Trajectory read_tum(const std::string& path) {
  toolchain::TextFile file(path);
  firmware::Trajectory trajectory;
  std::vector<std::string_view> fields;
  const auto take = [&](std::string_view row) {
    toolchain::split(row, ' ', fields);
    if (fields.empty() || fields.front().front() == '#') return;
    REQUIRE(fields.size() == 8);
    firmware::TimedPose pose;
    double v[7]{};
    REQUIRE(toolchain::parse_seconds(fields[0], pose.stamp_ns));
    for (std::size_t i = 0; i < 7; ++i) REQUIRE(toolchain::parse_double(fields[i + 1], v[i]));
    std::copy(v, v + 3, pose.p);
    pose.q[0] = v[6];
    std::copy(v + 3, v + 6, pose.q + 1);
    trajectory.push_back(pose);
  };
  for (std::string_view line; file.next(line);) take(line);
  take(file.tail());
  return trajectory;
}

}  // namespace sortie::testing
