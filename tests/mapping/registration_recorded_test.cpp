// SPDX-License-Identifier: BSD-3-Clause
// A recorded lidar, carried by hand, without odometry: between two scans it turns up to 48 degrees.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "mapping/registration/locator.hpp"
#include "tests/mapping/recorded_scans.hpp"

using namespace sortie;
using mapping::RigidPose;

namespace {
RigidPose between(const RigidPose& a, const RigidPose& b) {
  return {rt::rotate_back(a.q, b.p - a.p), rt::conjugate(a.q) * b.q};
}

struct Errors {
  std::vector<double> moves_m;  ///< of the motions between scans, sorted
  std::vector<double> turns_rad;
  double end_m{};
  double way_m{};
  std::uint64_t refused{};
};

Errors follow(const std::vector<tests::RecordedScan>& scans, std::size_t first) {
  std::vector<std::byte> memory(std::size_t{32} << 20);
  rt::Arena arena(memory);
  mapping::Locator locator({}, arena);
  REQUIRE(arena.refused() == 0);
  const auto truth = [&](std::size_t i) {
    return RigidPose{scans[i].pose().p_world_sensor_m, scans[i].pose().q_world_sensor};
  };
  Errors errors;
  RigidPose before;
  for (std::size_t i = first; i < scans.size(); ++i) {
    const mapping::Located& located = locator.locate(scans[i].view(), {});
    if (i > first) {
      const RigidPose motion = between(truth(i - 1), truth(i));
      const RigidPose off = between(motion, between(before, located.T_map_sensor));
      errors.moves_m.push_back(rt::norm(off.p));
      errors.turns_rad.push_back(rt::norm(rt::log_rotation(off.q)));
      errors.way_m += rt::norm(motion.p);
    }
    before = located.T_map_sensor;
  }
  errors.end_m = rt::norm(between(between(truth(first), truth(scans.size() - 1)), before).p);
  errors.refused = locator.located().counts.in - locator.located().counts.accepted - 1;
  std::sort(errors.moves_m.begin(), errors.moves_m.end());
  std::sort(errors.turns_rad.begin(), errors.turns_rad.end());
  return errors;
}
}  // namespace

TEST_CASE("a lidar that is carried by hand is followed without odometry", "[heavy]") {
  const auto scans = tests::read_rls(SORTIE_DATA_DIR "/lidar_os64/os64_thin4_000_109.rls");
  if (scans.empty()) {
    WARN("skipped: no recorded lidar in " SORTIE_DATA_DIR);
    return;
  }
  // From the start, where the lidar stands still at first, and from two places where it turns with an empty
  // map.
  for (const std::size_t first : {std::size_t{0}, std::size_t{27}, std::size_t{60}}) {
    const Errors errors = follow(scans, first);
    const auto rank = [](const std::vector<double>& sorted, double share) {
      return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    INFO("from scan " << first << ", way " << errors.way_m << " m, end " << errors.end_m << " m");
    INFO("moves p50, p99, max: " << rank(errors.moves_m, 0.5) << ' ' << rank(errors.moves_m, 0.99) << ' '
                                 << errors.moves_m.back());
    INFO("turns p50, p99, max: " << rank(errors.turns_rad, 0.5) << ' ' << rank(errors.turns_rad, 0.99) << ' '
                                 << errors.turns_rad.back());
    CHECK(errors.refused == 0);
    // None is lost, and the poses that these are compared with are themselves good to 1 cm and 0.1 degrees.
    CHECK(errors.moves_m.back() < 0.05);
    CHECK(errors.turns_rad.back() < 0.009);
    CHECK(rank(errors.moves_m, 0.99) < 0.02);
    CHECK(rank(errors.turns_rad, 0.99) < 0.0035);
    CHECK(rank(errors.moves_m, 0.5) < 0.0075);
    CHECK(errors.end_m < 0.005 * errors.way_m);
  }
}
