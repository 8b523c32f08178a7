// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "tests/bench/registration/judged_match.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;
constexpr int kScansOfMap = 6;
constexpr double kUsualShare = 0.9;  ///< of a robot that was tracked so far

struct BasinCount {
  int n{}, right{}, near{}, refused_right{}, false_accepted{}, recovered{};
};

void print_each(const char* what, int hall, const PoseError& error, const JudgedMatch& judged) {
  std::printf("%s: hall %d, %.3f m %.2f deg, matched %.2f known %.2f value %.3f crossed %.3f, %s\n", what,
              hall, error.move_m, error.turn_deg, judged.match.score.matched, judged.match.score.known,
              judged.match.score.value, judged.crossed, to_string(judged.verdict));
}

void basin(const StartError& start_error, const RegistrationSettings& settings) {
  const int cases = settings.cases > 0 ? settings.cases : 3000;
  const mapping::RegistrationConfig config;
  testing::Draws draws(settings.seed);
  BasinCount count;
  Rounds ms;
  for (int hall_number = 0; count.n < cases; ++hall_number) {
    const Hall hall(draws);
    const auto map = map_of(hall, config, kScansOfMap, draws);
    for (int i = 0; i < kScansOfHall && count.n < cases; ++i) {
      const PlacedScan scan = hall.scan(draws);
      const mapping::RigidPose start = start_beside(scan.pose, start_error, draws);
      const JudgedMatch judged = judged_match(*map, config, scan.points, start, kUsualShare);
      const PoseError error = pose_error(judged.match.pose, scan.pose);
      const bool right = error.within(0.02, 0.2);
      const bool accepted = judged.verdict == mapping::LocateVerdict::accepted;
      ++count.n;
      ms.add(judged.ms);
      count.recovered += judged.match.recovered ? 1 : 0;
      count.right += right ? 1 : 0;
      count.refused_right += right && !accepted ? 1 : 0;
      count.near += !right && error.within(0.1, 1.0) ? 1 : 0;
      count.false_accepted += !right && accepted ? 1 : 0;
      if (settings.each && right != accepted)
        print_each(right ? "right, refused" : "wrong, accepted", hall_number, error, judged);
      else if (settings.each && !right)
        print_each("lost, refused", hall_number, error, judged);
    }
  }
  std::printf("| %.1f m, %.0f deg, about %s | %d | %.2f %% | %d | %d | %d | %d | %.1f | %.1f | %.1f |\n",
              start_error.move_m, start_error.turn_rad * 180 / M_PI,
              start_error.upright ? "the upright" : "any axis", count.n, 100.0 * count.right / count.n,
              count.n - count.right, count.false_accepted, count.refused_right, count.recovered, ms.median(),
              ms.quantile(0.99), ms.high());
  std::fflush(stdout);
}

}  // namespace

void registration_basin(const RegistrationSettings& settings) {
  std::puts(
      "\n| start off by | n | within 2 cm and 0.2 deg | not | of these accepted | right, but refused | other "
      "starts tried | ms median | p99 | max |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
  for (const bool upright : {true, false}) {
    basin({0.5, 15 * M_PI / 180, upright}, settings);
    basin({1.0, 60 * M_PI / 180, upright}, settings);
  }
}

}  // namespace sortie::bench
