// SPDX-License-Identifier: BSD-3-Clause
// Clouds from the air on clouds from the ground: how many are placed, over the work that it takes.
#include "tests/bench/registration/front.hpp"
#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/registration_parts.hpp"
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

/// Cells and the planes that are grown over them are `times` as wide as they are by themselves.
void widen(std::vector<KnownScene>& scenes, double times) {
  for (KnownScene& known : scenes) {
    for (const mapping::CloudSensor sensor : {mapping::CloudSensor::camera, mapping::CloudSensor::laser}) {
      mapping::PlaneGrowingConfig config = mapping::growing_config(sensor);
      config.cell_m *= times;
      tests::AirGroundScene& scene = known.scene;
      (sensor == mapping::CloudSensor::camera ? scene.scene.source : scene.scene.target) =
          tests::grown(sensor == mapping::CloudSensor::camera ? scene.air : scene.ground, config);
    }
  }
}

struct Knobs {
  double times;
  std::uint32_t starts;
};

FrontCell measure(const std::vector<KnownScene>& scenes, const Knobs& knobs) {
  mapping::CloudRegistrationConfig config;
  config.starts = knobs.starts;
  const auto wide = [&knobs](mapping::CloudSensor sensor) {
    mapping::SightConfig sight = mapping::sight_config(sensor);
    sight.cell_m *= knobs.times;
    return sight;
  };
  tests::CloudRig rig(config);
  tests::OwnedSight air(wide(mapping::CloudSensor::camera)), ground(wide(mapping::CloudSensor::laser));
  tests::AirGroundTally tally;
  Rounds ms, units;
  for (const KnownScene& known : scenes) {
    air.fill(known.scene.air);
    ground.fill(known.scene.ground);
    const double begin = step_cpu_ms();
    std::uint64_t all = std::uint64_t{1} << 60;
    if (rig.registration->begin(known.scene.scene.source, air.layer, known.scene.scene.target, ground.layer,
                                known.estimate) == Status::ok)
      (void)rig.registration->run(all);
    ms.add(step_cpu_ms() - begin);
    const mapping::CloudResult& result = rig.registration->result();
    units.add(1e-6 * static_cast<double>(result.units));
    tests::judge(tally, known.scene, result, false);
  }
  const double n = static_cast<double>(scenes.size());
  FrontCell cell;
  cell.curve = "cells " + decimals(knobs.times, 2) + " times as wide";
  cell.label = std::to_string(knobs.starts);
  cell.cost = ms.median();
  cell.error = 100.0 * (1.0 - tally.tally.close / n);
  cell.by_itself = knobs.times == 1.0 && knobs.starts == mapping::CloudRegistrationConfig{}.starts;
  cell.row = {decimals(knobs.times, 2),
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
  std::vector<KnownScene> scenes = scenes_of(settings.cases_or(40), settings.seed);
  std::vector<FrontCell> cells;
  for (const double times : {1.0, 0.75, 1.5}) {
    if (times != 1.0) widen(scenes, times);
    for (const std::uint32_t starts : {1u, 2u, 4u, 6u, 8u}) cells.push_back(measure(scenes, {times, starts}));
  }
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
            {"cells", "starts", "n", "placed", "near", "refused", "wrong", "mm 95 %", "M units median",
             "most", "ms median", "max"},
            cells, FrontRows::all);
  report.note(
      "clouds",
      "Random buildings with five faces in common in three directions; position known to 3 m, yaw to 6 "
      "degrees. Cells: times the usual 0.6 m of the air's and 0.4 m of the ground's. Starts: places "
      "that planes lead to and that are looked at. Placed: to 5 cm, 0.3 degrees and 0.5 % of scale.");
}

}  // namespace sortie::bench
