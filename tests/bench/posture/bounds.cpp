// SPDX-License-Identifier: BSD-3-Clause
// How wide the bounds of a posture are, what they take, and whether drawn grounds stay within them.
#include <cmath>
#include <memory>
#include <stdexcept>

#include "planner/posture_bounds.hpp"
#include "rt/posix/clock.hpp"
#include "tests/bench/posture/posture_parts.hpp"
#include "tests/planner/posture_bounded_course.hpp"

namespace sortie::bench {

void measure_posture_bounds(const PostureSettings& settings, Report& report) {
  using namespace planner;
  constexpr double kDegrees = 57.29577951308232;
  constexpr int kDrawn = 10;
  const int cases = settings.cases_or(50);
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  Json rows = Json::array();
  for (const double share : {0.0, 0.1, 0.3, 0.6}) {
    for (const std::uint32_t units : {256u, 512u, 1024u, 2048u}) {
      Rounds pitch, roll, ms, used;
      int may_tip = 0, drawn = 0, outside = 0;
      for (int k = 0; k < cases; ++k) {
        const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(k);
        hil::Random random(seed, 0x62656e63);
        const BoxCourse course = random_course(kCourseFamilies[seed % 5], random);
        FlipperSet flippers;
        for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
        const StandPose pose{0.0, 0.0, random.uniform(-3.0, 3.0)};
        BoundedCourse ground{&course, share, 0.04, seed, 0};
        PostureBounds b;
        if (solver->look(ground.view(), pose) != Status::ok) throw std::runtime_error("posture: no look");
        const rt::Nanoseconds begin = rt::posix::thread_cpu_now();
        if (bounder->bound(*solver, flippers, units, b) != Status::ok)
          throw std::runtime_error("posture: no bounds");
        ms.add(1e-6 * static_cast<double>(rt::posix::thread_cpu_now() - begin));
        used.add(b.units);
        if (b.may_tip) ++may_tip;
        pitch.add(kDegrees * (b.pitch_rad.high - b.pitch_rad.low));
        roll.add(kDegrees * (b.roll_rad.high - b.roll_rad.low));
        for (ground.sample = 1; ground.sample <= kDrawn; ++ground.sample) {
          Posture p;
          if (solver->look(ground.view(), pose) != Status::ok || solver->rest(flippers, p) != Status::ok)
            throw std::runtime_error("posture: no rest");
          const double widest = PostureBounder::kWidest_rad;
          if (p.rest != Rest::stands || p.settled_rad > 1e-3 || std::fabs(p.pitch_rad) > widest ||
              std::fabs(p.roll_rad) > widest)
            continue;
          ++drawn;
          if (p.pitch_rad < b.pitch_rad.low || p.pitch_rad > b.pitch_rad.high ||
              p.roll_rad < b.roll_rad.low || p.roll_rad > b.roll_rad.high)
            ++outside;
        }
      }
      rows.push_back({std::round(100 * share), units, std::round(used.median()),
                      std::round(100 * ms.median()) / 100, std::round(10 * pitch.median()) / 10,
                      std::round(10 * pitch.quantile(0.9)) / 10, std::round(10 * roll.median()) / 10, may_tip,
                      cases, drawn, outside});
    }
  }
  report.add_table("bounds",
                   {"open cells %", "units", "used", "ms", "pitch wide p50 deg", "p90", "roll wide p50",
                    "may tip", "of", "drawn", "outside"},
                   rows);
  report.note(
      "bounds",
      "Open cells lie up to 4 cm lower or higher than the course. Drawn grounds take any heights within; "
      "those that tip, do not settle or stand steeper than 40 degrees are not counted.");
}

}  // namespace sortie::bench
