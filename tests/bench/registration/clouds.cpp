// SPDX-License-Identifier: BSD-3-Clause
// Clouds from the air on clouds from the ground: how many are placed, over the work that it takes.
#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/front.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace sortie::bench {
namespace {

struct KnownScene {
  tests::AirGroundScene scene;
  mapping::PlaneEstimate estimate;
};

/// Buildings with five faces in common in three directions; position known to 3 m, yaw to 6 degrees.
std::vector<KnownScene> scenes_of(int wanted, std::uint64_t seed) {
  std::vector<KnownScene> scenes;
  for (std::uint32_t i = 0; static_cast<int>(scenes.size()) < wanted; ++i) {
    tests::WorldRandom random(static_cast<std::uint32_t>(60'000 + 1000 * (seed - 1)) + i);
    tests::AirGroundScene scene = tests::cloud_scene(0, random);
    const mapping::PlaneEstimate estimate = tests::gps(scene.scene, true, 0.05, random);
    if (tests::bin_of(scene) < 4) scenes.push_back({std::move(scene), estimate});
  }
  return scenes;
}

struct Knobs {
  double times;
  std::uint32_t starts;
  std::uint32_t grids;
};

FrontCell measure(const std::vector<KnownScene>& scenes, const Knobs& knobs) {
  mapping::CloudMatchConfig config;
  config.registration.starts = knobs.starts;
  config.grids = knobs.grids;
  tests::CloudMatchRig rig(config, knobs.times);
  tests::AirGroundTally tally;
  Rounds ms, units;
  for (const KnownScene& known : scenes) {
    rig.begin(known.scene, known.estimate);
    const double begin = step_cpu_ms();
    std::uint64_t all = std::uint64_t{1} << 60;
    (void)rig.match->run(all);
    ms.add(step_cpu_ms() - begin);
    const mapping::CloudResult& result = rig.match->result();
    units.add(1e-6 * static_cast<double>(result.units));
    tests::judge(tally, known.scene, result, false);
  }
  const double n = static_cast<double>(scenes.size());
  const bool usual = knobs.times == 1.0 && knobs.starts == mapping::CloudRegistrationConfig{}.starts;
  FrontCell cell;
  cell.curve = "cells " + decimals(knobs.times, 2) + " times, " + std::to_string(knobs.starts) + " starts";
  cell.label = std::to_string(knobs.grids);
  cell.cost = ms.median();
  cell.error = 100.0 * (1.0 - tally.tally.close / n);
  cell.by_itself = usual && knobs.grids == mapping::CloudMatchConfig{}.grids;
  cell.row = {decimals(knobs.times, 2),
              knobs.grids,
              knobs.starts,
              scenes.size(),
              tally.tally.close,
              tally.tally.near,
              tally.tally.refused,
              tally.tally.wrong,
              decimals(1e3 * tests::quantile(tally.position_m, 0.95), 1),
              decimals(units.median(), 1),
              decimals(units.high(), 1),
              decimals(ms.median(), 0),
              decimals(ms.high(), 0)};
  return cell;
}

}  // namespace

void measure_registration_clouds(const RegistrationSettings& settings, Report& report) {
  const std::vector<KnownScene> scenes = scenes_of(settings.cases_or(40), settings.seed);
  std::vector<FrontCell> cells;
  // Cells, starts, grids.
  constexpr Knobs kKnobs[] = {{1.0, 6, 0}, {1.0, 6, 1}, {1.0, 6, 2}, {1.0, 6, 3},  {1.0, 6, 5},
                              {1.0, 6, 8}, {1.0, 1, 0}, {1.0, 1, 3}, {0.75, 6, 3}, {1.5, 6, 3}};
  for (const Knobs& knobs : kKnobs) cells.push_back(measure(scenes, knobs));
  const Picture picture{"bench-registration-clouds",
                        "clouds",
                        "Clouds from the air on the ground's: not placed, over run time",
                        "run time of a registration, median, ms",
                        "not placed, %",
                        true,
                        false,
                        false,
                        {}};
  add_front(report, picture,
            {"cells", "grids", "starts", "n", "placed", "near", "refused", "wrong", "mm 95 %",
             "M units median", "most", "ms median", "max"},
            cells, FrontRows::all);
  report.note(
      "clouds",
      "Random buildings with five faces in common in three directions; position known to 3 m, yaw to 6 "
      "degrees. Cells: times the usual 0.6 m of the air's and 0.4 m of the ground's. Grids: of cells twice "
      "as wide that are asked as well, until two agree. Starts: places that planes lead to and that are "
      "looked at. Numbers in the picture: grids. Placed: to 5 cm, 0.3 degrees and 0.5 % of scale.");
}

}  // namespace sortie::bench
