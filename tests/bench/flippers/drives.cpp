// SPDX-License-Identifier: BSD-3-Clause
// The plant over drawn steps, stairs and blocks with the policy in the loop, beside fixed postures.
#include <cmath>

#include "tests/bench/flippers/flipper_parts.hpp"
#include "tests/planner/flipper_drive.hpp"

namespace sortie::bench {
namespace {
using namespace planner;

/// Sizes are drawn; the policy was not made on these.
DrivenCourse drawn_course(int family, std::uint64_t seed) {
  hil::Random random(seed, 0x64726976);
  const double high = random.uniform(0.05, 0.22);
  switch (family) {
    case 0:
      return {"step up and down", 4.2, [high](hil::PlantScene& s) {
                (void)s.add_box({1.9, 0, 0.5 * high}, {}, {0.9, 1.0, 0.5 * high});
              }};
    case 1: {
      const double run = random.uniform(0.25, 0.35), rise = random.uniform(0.1, 0.18);
      return {"stairs down", 5.0, [run, rise](hil::PlantScene& s) {
                (void)hil::add_stairs(s, {{3.4, 0, 0}, 3.14159265358979}, {4, run, rise, 1.6, 3.4});
              }};
    }
    case 2: {
      const double run = random.uniform(0.25, 0.35), rise = random.uniform(0.1, 0.18);
      return {"stairs up", 3.2, [run, rise](hil::PlantScene& s) {
                (void)hil::add_stairs(s, {{1.0, 0, 0}, 0}, {4, run, rise, 1.6, 2.5});
              }};
    }
    default:
      return {"rubble", 3.4, [seed](hil::PlantScene& s) {
                (void)hil::add_rubble(s, {{1.0, 0, 0}, 0}, 1.2, 1.4, 25, seed);
              }};
  }
}

}  // namespace

void measure_flipper_drives(const FlipperSettings& settings, Report& report) {
  const int cases = settings.cases_or(8);
  Json rows = Json::array();
  for (int family = 0; family < 4; ++family) {
    struct Row {
      Rounds rate, seconds;
      int arrived{}, tipped{}, stopped{};
      double belly_s{};
      void add(const DriveResult& r) {
        arrived += r.arrived ? 1 : 0;
        tipped += r.tipped ? 1 : 0;
        stopped += !r.arrived && r.jobs > 0 && r.last == FlipperVerdict::stop ? 1 : 0;
        belly_s += r.belly_s;
        if (!r.arrived) return;
        rate.add(r.peak_pitch_rad_s);
        seconds.add(r.seconds);
      }
    };
    Row led;
    std::vector<Row> held(std::size(kFixedPostures));
    const char* name = "";
    for (int k = 0; k < cases; ++k) {
      const DrivenCourse course = drawn_course(family, settings.seed + static_cast<std::uint64_t>(k));
      name = course.name;
      const auto policy = flipper_policy();
      led.add(drive(course, course.ground.view(), policy.get(), {{0.5, 0.5, 0.5, 0.5}}, 0.9));
      for (std::size_t f = 0; f < held.size(); ++f)
        held[f].add(drive(course, course.ground.view(), nullptr, kFixedPostures[f], 0.9));
    }
    // The best fixed posture: the most arrivals, then the lowest rate.
    std::size_t best = 0;
    for (std::size_t f = 1; f < held.size(); ++f) {
      const bool more = held[f].arrived > held[best].arrived;
      const bool as_many = held[f].arrived == held[best].arrived && held[f].arrived > 0;
      if (more || (as_many && held[f].rate.median() < held[best].rate.median())) best = f;
    }
    const auto row = [&](const std::string& who, const Row& r) {
      const auto median = [](const Rounds& values) {
        return values.empty() ? 0.0 : std::round(100 * values.median()) / 100;
      };
      rows.push_back({name, who, cases, r.arrived, r.tipped, r.stopped, median(r.rate),
                      r.rate.empty() ? 0.0 : std::round(100 * r.rate.high()) / 100, median(r.seconds),
                      std::round(10 * r.belly_s) / 10});
    };
    row("policy", led);
    char fixed[48];
    std::snprintf(fixed, sizeof fixed, "best fixed (%.1f, %.1f)", kFixedPostures[best].angle_rad[0],
                  kFixedPostures[best].angle_rad[2]);
    row(fixed, held[best]);
  }
  report.add_table("drives",
                   {"course", "who", "n", "arrived", "tipped", "stopped and said so",
                    "peak pitch rate p50 rad/s", "worst", "seconds p50", "belly s"},
                   rows);
  report.note("drives", "Heights are the plant's own solids. Rates and times are of those that arrived.");
}

}  // namespace sortie::bench
