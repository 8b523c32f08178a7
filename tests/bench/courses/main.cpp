// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-courses: drivers of the tracked vehicle's flippers over drawn courses. Prints one JSON object;
// `sortie bench courses` runs it and shows the tables.
#include "tests/bench/courses/course_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<CourseSettings> kCourseParts[] = {{"tuning", measure_tuning},
                                                      {"drivers", measure_drivers}};

int run(int argc, char** argv) {
  CourseSettings settings;
  std::string only;
  read_arguments(argc, argv,
                 {{"--cases", settings.cases, 1, 1e5},
                  {"--seed", settings.seed, 0, 1e9},
                  {"--family", settings.family},
                  {"--only", only}});
  print_parts<CourseSettings>(
      kCourseParts, settings, only,
      {{"cases", settings.cases}, {"seed", settings.seed}, {"family", settings.family}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-courses",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
