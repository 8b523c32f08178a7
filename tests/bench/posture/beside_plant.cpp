// SPDX-License-Identifier: BSD-3-Clause
// Postures beside the plant at rest, and their error over run time.
#include <cmath>
#include <stdexcept>

#include "rt/posix/clock.hpp"
#include "tests/bench/posture/posture_parts.hpp"
#include "tests/bench/report/picture.hpp"
#include "tests/planner/posture_rests.hpp"

namespace sortie::bench {
namespace {
using planner::CourseFamily;
using planner::PostureConfig;
using planner::PostureSolver;
using planner::RestErrors;

double rounded(double value, double step) { return std::round(value / step) * step; }

std::unique_ptr<PostureSolver> solver_of(const PostureConfig& config) {
  auto solver = std::make_unique<PostureSolver>(planner::posture_vehicle({}), config);
  if (solver->usable() != Status::ok) throw std::runtime_error("posture: the plant's vehicle cannot be used");
  return solver;
}

constexpr int kFlippersTried = 16;  // at each place, as a choice of flippers would try them

/// Times of one look and of one rest, us, a course each.
struct PostureTimes {
  Rounds look_us, rest_us;
};

/// Courses of all families one after another, `poses` of each.
void time_postures(PostureSolver& solver, double cell_m, std::uint64_t seed, int poses, PostureTimes& times) {
  for (const CourseFamily family : planner::kCourseFamilies) {
    for (int k = 0; k < poses; ++k) {
      hil::Random random(seed + static_cast<std::uint64_t>(k), 0x74696d65);
      planner::BoxCourse course = planner::random_course(family, random);
      course.cell_m = cell_m;
      // Cells are looked up, not computed: a map is there already.
      std::vector<planner::HeightCell> cells(200 * 200);
      for (int n = 0; n < 200 * 200; ++n)
        cells[static_cast<std::size_t>(n)] = planner::BoxCourse::cell(&course, n % 200 - 100, n / 200 - 100);
      const planner::HeightView view{cells.data(),
                                     [](const void* ground, std::int64_t i, std::int64_t j) {
                                       const auto* all = static_cast<const planner::HeightCell*>(ground);
                                       return all[(j + 100) * 200 + i + 100];
                                     },
                                     cell_m};
      const planner::StandPose pose{0.0, 0.0, random.uniform(-3.0, 3.0)};
      planner::Posture posture;
      planner::FlipperSet flippers;
      const rt::Nanoseconds begin = rt::posix::thread_cpu_now();
      Status status = solver.look(view, pose);
      const rt::Nanoseconds between = rt::posix::thread_cpu_now();
      for (int n = 0; n < kFlippersTried && status == Status::ok; ++n) {
        for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
        status = solver.rest(flippers, posture);
      }
      const rt::Nanoseconds end = rt::posix::thread_cpu_now();
      if (status != Status::ok) throw std::runtime_error("posture: no answer on a course");
      times.look_us.add(1e-3 * static_cast<double>(between - begin));
      times.rest_us.add(1e-3 * static_cast<double>(end - between) / kFlippersTried);
    }
  }
}

RestErrors errors_of(PostureSolver& solver, CourseFamily family, const PostureSettings& settings, int poses,
                     bool borders, double cell_m) {
  RestErrors errors;
  for (int k = 0; k < poses; ++k)
    errors.add(
        rest_beside_plant(solver, family, settings.seed + static_cast<std::uint64_t>(k), borders, cell_m));
  return errors;
}

}  // namespace

void measure_posture_plant(const PostureSettings& settings, Report& report) {
  const int poses = settings.cases_or(400);
  const auto solver = solver_of({});
  Json rows = Json::array();
  for (const bool borders : {true, false}) {
    for (const CourseFamily family : planner::kCourseFamilies) {
      const RestErrors e = errors_of(*solver, family, settings, poses, borders, 0.05);
      rows.push_back({planner::kCourseNames[static_cast<int>(family)], borders ? "on borders" : "anywhere",
                      e.count, rounded(RestErrors::quantile(e.tilt_deg, 0.5), 0.01),
                      rounded(RestErrors::quantile(e.tilt_deg, 0.9), 0.01),
                      rounded(RestErrors::quantile(e.tilt_deg, 0.99), 0.1),
                      rounded(RestErrors::quantile(e.height_mm, 0.5), 0.1),
                      rounded(RestErrors::quantile(e.height_mm, 0.9), 0.1), e.off, e.near_edge, e.other_rest,
                      e.not_standing, e.no_rest});
    }
  }
  report.add_table(
      "plant",
      {"ground", "edges", "n", "tilt p50 deg", "p90", "p99", "height p50 mm", "p90", "above 2 deg",
       "of them near tipping", "another rest", "not standing", "plant never rests"},
      rows);
  report.note(
      "plant",
      "Tilt: the larger error of pitch and roll. Another rest: more than 2 degrees off, and a posture that "
      "starts at the plant's tilt stays there. Near tipping: at the plant's tilt the centre of mass lies "
      "within 1.5 samples of the edge of what carries it.");
}

void measure_posture_sweep(const PostureSettings& settings, Report& report) {
  const int poses = settings.cases_or(100);
  Json rows = Json::array();
  Picture picture{"bench-posture-sweep",
                  "sweep",
                  "Error of pitch and roll over run time",
                  "us a rest (median)",
                  "deg (90th percentile)",
                  true,
                  true,
                  false,
                  {}};
  struct Knob {
    const char* name;
    double cell_m, spacing_m;
    int sweeps;
  };
  const auto measure = [&](const Knob& knob, Curve& curve) {
    PostureConfig config;
    config.ground.spacing_m = knob.spacing_m;
    config.sweeps = knob.sweeps;
    const auto solver = solver_of(config);
    PostureTimes times;
    time_postures(*solver, knob.cell_m, settings.seed, std::min(poses, 40), times);
    RestErrors all;
    for (const CourseFamily family : planner::kCourseFamilies) {
      for (int k = 0; k < poses; ++k)
        all.add(rest_beside_plant(*solver, family, settings.seed + static_cast<std::uint64_t>(k), false,
                                  knob.cell_m));
    }
    const double p90 = RestErrors::quantile(all.tilt_deg, 0.9);
    rows.push_back({knob.name, 100 * knob.cell_m, 1000 * knob.spacing_m, knob.sweeps,
                    rounded(times.look_us.median(), 0.1), rounded(times.rest_us.median(), 0.1),
                    rounded(times.rest_us.quantile(0.99), 0.1),
                    rounded(RestErrors::quantile(all.tilt_deg, 0.5), 0.01), rounded(p90, 0.01),
                    rounded(RestErrors::quantile(all.height_mm, 0.9), 0.1), all.off, all.not_standing});
    curve.x.push_back(times.rest_us.median());
    curve.y.push_back(p90);
  };
  Curve cells{"cells of 2.8 to 10 cm", {}, {}, {}, "", -1};
  for (const double cell : {0.028, 0.035, 0.05, 0.07, 0.1}) measure({"cell", cell, 0.0205, 8}, cells);
  Curve spacings{"samples every 20 to 37 mm", {}, {}, {}, "", -1};
  for (const double spacing : {0.0205, 0.025, 0.03, 0.037}) measure({"spacing", 0.05, spacing, 8}, spacings);
  Curve sweeps{"1 to 16 sweeps", {}, {}, {}, "", -1};
  for (const int count : {1, 2, 3, 4, 6, 8, 16}) measure({"sweeps", 0.05, 0.025, count}, sweeps);
  picture.curves = {cells, spacings, sweeps};
  report.add_table("sweep",
                   {"knob", "cell cm", "spacing mm", "sweeps", "look us", "rest us", "p99", "tilt p50 deg",
                    "p90", "height p90 mm", "above 2 deg", "not standing"},
                   rows);
  add_picture(report, picture);
  // The goal's figure: one rest as the defaults have it.
  PostureTimes times;
  const auto solver = solver_of({});
  time_postures(*solver, 0.05, settings.seed + 1000, poses, times);
  Figure figure;
  figure.group = "sweep";
  figure.what = "one rest at a place that was looked at";
  figure.unit = "us";
  figure.n = static_cast<std::uint64_t>(times.rest_us.size());
  figure.ours = spread(times.rest_us.median());
  set_goal(figure, "20 us", times.rest_us.median() <= 20.0);
  report.add(figure);
}

}  // namespace sortie::bench
