// SPDX-License-Identifier: BSD-3-Clause
// The tables behind the ground planner: motions, their stations, and what the footprints cover.
#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <tuple>

#include "tests/planner/ground_twin.hpp"

namespace sortie::planner::test {
namespace {

using StationKey = std::tuple<int, int, int>;

// The station of a mirrored motion: y and the heading change their signs.
StationKey mirrored(const MotionStation& s) {
  const int slot =
      s.slot < kHeadings ? wrap_heading(-s.slot) : kHeadings + wrap_heading(-(s.slot - kHeadings) - 1);
  return {s.x, -s.y, slot};
}
StationKey turned(const MotionStation& s) {
  const int slot =
      s.slot < kHeadings ? wrap_heading(s.slot + 4) : kHeadings + wrap_heading(s.slot - kHeadings + 4);
  return {-s.y, s.x, slot};
}

}  // namespace

TEST_CASE("ground lattice: motions mirrored and turned by a quarter are motions of the table") {
  const MotionTable table(GroundPathConfig{});
  REQUIRE(table.is_whole());
  const auto has = [&table](std::int32_t heading, const Motion& like, int x, int y, int end,
                            const std::set<StationKey>& stations) {
    for (std::uint32_t m = 0; m < kMotions; ++m) {
      const Motion& motion = table.motion(heading, m);
      std::set<StationKey> own;
      for (const MotionStation& s : table.stations(motion)) own.insert({s.x, s.y, s.slot});
      if (motion.x == x && motion.y == y && motion.heading == end && motion.time_ms == like.time_ms &&
          motion.reverse == like.reverse && own == stations)
        return true;
    }
    return false;
  };
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    for (std::uint32_t m = 0; m < kMotions; ++m) {
      CAPTURE(h, m);
      const Motion& motion = table.motion(h, m);
      std::set<StationKey> mirror;
      std::set<StationKey> turn;
      for (const MotionStation& s : table.stations(motion)) {
        mirror.insert(mirrored(s));
        turn.insert(turned(s));
      }
      CHECK(mirror.size() == motion.stations);
      CHECK(has(wrap_heading(-h), motion, motion.x, -motion.y, wrap_heading(-motion.heading), mirror));
      CHECK(has(wrap_heading(h + 4), motion, -motion.y, motion.x, wrap_heading(motion.heading + 4), turn));
    }
  }
}

TEST_CASE("ground lattice: stations' footprints cover the robot all along every motion") {
  const std::int32_t sizes[][3] = {{100, 400, 300}, {100, 110, 70}, {50, 600, 250}, {200, 400, 300}};
  for (const auto& [cell, length, width] : sizes) {
    GroundPathConfig config;
    config.cell_mm = cell;
    config.half_length_mm = length;
    config.half_width_mm = width;
    CAPTURE(cell, length, width);
    const MotionTable table(config);
    const FootprintTable footprints(config);
    int missing = 0;
    int touched = 0;
    int allowed = 0;
    for (std::int32_t h = 0; h < kHeadings; ++h) {
      for (std::uint32_t m = 0; m < kMotions; ++m) {
        const Motion& motion = table.motion(h, m);
        std::array<bool, 49 * 49> cells{};
        std::array<bool, 49 * 49> under{};
        const auto number = [](int x, int y) { return static_cast<std::size_t>(49 * (y + 24) + x + 24); };
        const auto add = [&](int x, int y, std::int32_t slot) {
          const std::int32_t reach = footprints.reach(slot);
          for (std::int32_t dy = -reach; dy <= reach; ++dy)
            for (int dx = footprints.row(slot, dy).low; dx <= footprints.row(slot, dy).high; ++dx)
              cells[number(x + dx, y + dy)] = true;
        };
        add(0, 0, h);
        for (const MotionStation& s : table.stations(motion)) add(s.x, s.y, s.slot);
        const int around = footprints.reach() + 5;
        for (int k = 0; k <= 100; ++k) {
          const OutlinePose pose = outline_at({0, 0, 0, h}, motion, k / 100.0);
          for (int y = -around; y <= around; ++y)
            for (int x = -around; x <= around; ++x)
              if (!under[number(x, y)]) under[number(x, y)] = outline_touches(config, pose, x, y);
        }
        for (std::size_t i = 0; i < cells.size(); ++i) missing += under[i] && !cells[i] ? 1 : 0;
        touched += static_cast<int>(std::count(under.begin(), under.end(), true));
        allowed += static_cast<int>(std::count(cells.begin(), cells.end(), true));
      }
    }
    CHECK(missing == 0);
    CHECK(allowed < 4 * touched);
    REQUIRE(footprints.reach() + 5 <= 24);
  }
}

TEST_CASE("ground lattice: a motion's time is that of its way or its turn, and a tenth more at the most") {
  GroundPathConfig config;
  config.cell_mm = 1000;  // so that whole ms round nothing away
  const MotionTable table(config);
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    for (std::uint32_t m = 0; m < kMotions; ++m) {
      CAPTURE(h, m);
      const Motion& motion = table.motion(h, m);
      double length = 0.0;
      double turn = 0.0;
      OutlinePose last = outline_at({0, 0, 0, h}, motion, 0.0);
      for (int k = 1; k <= 500; ++k) {
        const OutlinePose pose = outline_at({0, 0, 0, h}, motion, k / 500.0);
        length += std::hypot(pose.x - last.x, pose.y - last.y);
        turn += std::abs(std::remainder(pose.yaw - last.yaw, 2 * M_PI));
        last = pose;
      }
      const double speed = motion.reverse ? config.reverse_mm_s : config.speed_mm_s;
      const double drive_ms = 1e3 * length * config.cell_mm / speed;
      const double turn_ms = 1e6 * turn / config.turn_mrad_s;
      CHECK(motion.time_ms >= std::max(drive_ms, turn_ms) - 5.0);
      CHECK(motion.time_ms <= 1.1 * std::max(drive_ms, turn_ms) + 5.0);
    }
  }
}

}  // namespace sortie::planner::test
