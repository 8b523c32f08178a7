// SPDX-License-Identifier: BSD-3-Clause
// The parts of the benchmark of courses; what each of them says goes into one report.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil/plant/course_drivers.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What a run is asked for.
struct CourseSettings {
  int cases{2};  ///< courses a family
  std::uint64_t seed{1};
  std::string family;  ///< one alone by its name; all where it is empty
};

/// The rules, and that who stands still for 4 s has had his time: no driver here ever waits.
hil::JudgeConfig bench_rules();

/// The families that are asked for. Throws std::invalid_argument with the names there are.
std::vector<hil::TerrainFamily> families_of(const CourseSettings& settings);

/// Case `k` of a family: difficulties evenly from easy to hard.
hil::Course course_of(const CourseSettings& settings, hil::CourseUse use, hil::TerrainFamily family, int k);

/// A driver by name.
struct NamedDriver {
  std::string name;
  std::unique_ptr<hil::FlipperDriver> driver;
};

/// The drivers beside the fixed postures: today's missions, the operator by script.
std::vector<NamedDriver> other_drivers();

/// Drives over courses for tuning, one row a driver.
struct TuningTable {
  Json rows = Json::array();
  std::size_t best{};  ///< of hil::fixed_postures(): passes most, and of equals tips least
};
/// Driven once a process: the settings of the first call, since a run has but one.
const TuningTable& tuning_table(const CourseSettings& settings);

/// Every fixed posture, and the other drivers, over the courses for tuning.
void measure_tuning(const CourseSettings& settings, Report& report);
/// The drivers over the courses for judging, family by family, with the best fixed posture of tuning.
void measure_drivers(const CourseSettings& settings, Report& report);

}  // namespace sortie::bench
