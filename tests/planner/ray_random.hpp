// SPDX-License-Identifier: BSD-3-Clause
// Random tasks for the ray scheduler, with all its settings at their ends: rays that are all alike, rays that
// are worth nothing, no ray, more rays than directions, tables of 1 to 64 lines, one unit at a time. What a
// task's plan, budget and certificate must keep.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "rt/digest.hpp"
#include "tests/planner/ray_small.hpp"
#include "tests/planner/ray_twin.hpp"

namespace sortie::tests {

/// A task as its seed says.
class RandomRays {
 public:
  explicit RandomRays(std::uint64_t seed)
      : random_(scene_hash(seed)), config_(make_config()), map_(make_map()), owned_(config_) {
    fill_map();
    make_poses();
  }

  const planner::RaySchedulerConfig& config() const { return config_; }
  planner::RayScheduler& scheduler() { return owned_.scheduler; }
  mapping::OccupancyView view() const { return map_.map.view(); }
  const std::vector<mapping::SensorPose>& poses() const { return poses_; }
  std::uint64_t draw(std::uint64_t n) { return random_() % n; }
  bool one_of(std::uint64_t n) { return draw(n) == 0; }
  template <class T>
  T any(std::initializer_list<T> values) {
    return values.begin()[draw(values.size())];
  }

 private:
  planner::RaySchedulerConfig make_config() {
    planner::RaySchedulerConfig config;
    planner::RaySensor& sensor = config.sensor;
    const bool tiny = one_of(3);
    sensor.columns = 1 + static_cast<std::uint32_t>(draw(tiny ? 3 : 12));
    sensor.rows = 1 + static_cast<std::uint32_t>(draw(tiny ? 2 : 6));
    sensor.width_rad = any({0.0, 1e-9, 0.02, 0.5, 2.0, 2.0, 6.0});  // 0: all rays are one
    sensor.height_rad = any({0.0, 0.02, 0.3, 1.5, 1.5});
    sensor.range_m = any({0.05, 0.6, 1.0, 2.0, 5.0});
    const std::uint32_t all = sensor.rays();
    config.rays = any({0u, 1u, all - 1, all, all + 5});
    if (!one_of(4)) config.rays = 1 + static_cast<std::uint32_t>(draw(all));
    config.positions = 1 + static_cast<std::uint32_t>(draw(3));
    config.map_cells = 1u << 12;
    const std::uint64_t lines = any({4u, 16u, 64u});
    config.table_lines = 1 + static_cast<std::uint32_t>(draw(lines));
    if (one_of(3)) config.table_lines = 0;
    config.path_words = any({0u, 0u, 1u, 40u});
    config.coarse_log2 = any({0u, 1u, 2u, 2u, 2u, 3u, 6u});
    config.explored = any({0u, 1u, 1 + all / 2});
    config.optimism = any({1.0, 1.0, 1.5, 4.0});
    config.slack = any({0.0, 0.02, 0.5});
    config.tries = any({1u, 7u, 150u});
    config.position_first = !one_of(4);
    config.joint = !one_of(4);
    config.exact = !one_of(8);
    config.certify = !one_of(8);
    config.model.unknown = one_of(3) ? planner::UnknownSpace::stop : planner::UnknownSpace::prior;
    config.model.least_visible = any({0.004, 0.004, 0.0, 0.1});
    return config;
  }

  mapping::OccupancyConfig make_map() {
    mapping::OccupancyConfig config;
    config.size[0] = 4 + static_cast<std::int32_t>(draw(17));
    config.size[1] = 4 + static_cast<std::int32_t>(draw(17));
    config.size[2] = 2 + static_cast<std::int32_t>(draw(7));
    config.anchor[0] = 0.5;
    return config;
  }

  // Few kinds of cells, so that ties are common; one kind alone at times.
  void fill_map() {
    const std::uint64_t kinds = 1 + draw(6);
    std::int8_t codes[6];
    for (std::int8_t& code : codes) code = static_cast<std::int8_t>(static_cast<int>(draw(255)) - 127);
    if (one_of(3)) codes[0] = mapping::kUnknownCell;
    if (one_of(6)) codes[0] = -127;
    for (std::int8_t& cell : map_.cells) cell = codes[draw(kinds)];
  }

  // At times all in one place, at times out of the window, where nothing is worth anything.
  void make_poses() {
    const mapping::OccupancyView map = view();
    const bool one_place = one_of(4);
    const std::uint64_t outside = one_of(6) ? 1 : 12;
    for (std::uint32_t p = 0; p < config_.positions; ++p) {
      if (p > 0 && one_place) {
        poses_.push_back(poses_[0]);
        continue;
      }
      rt::Vector3 at;
      double* to[3] = {&at.x, &at.y, &at.z};
      for (int a = 0; a < 3; ++a)
        *to[a] = map.voxel_size_m * (map.low[a] + 0.001 + 0.998 * share() * map.size[a]);
      if (one_of(outside)) at.x += 1000.0;
      const double yaw = 6.0 * share();
      const double pitch = any({0.0, 0.0, -0.5, -0.2, 0.1, 0.4});
      poses_.push_back({at, rt::exp_rotation({0, pitch, yaw})});
    }
  }
  double share() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  std::mt19937_64 random_;
  planner::RaySchedulerConfig config_;
  RayMap map_;
  OwnedScheduler owned_;
  std::vector<mapping::SensorPose> poses_;
};

/// How many tasks were of which kind, and what was wrong.
struct RandomTally {
  std::vector<std::string> faults;  ///< with their seeds
  int exact{};                      ///< plans of the exact stage
  int full{};                       ///< tables that were full
  int certified{};
  int full_certified{};
  int tried_all{};  ///< bounds beside the best of all plans
  int all_taken{};  ///< K >= N > 0
  int worthless{};
  int single{};      ///< spent one unit at a time
  double dearest{};  ///< step, as a share of what was said
};

/// Plans one random task, and what it must keep.
class RandomJudge {
 public:
  RandomJudge(std::uint64_t seed, RandomTally& tally) : seed_(seed), tally_(&tally), rays_(seed) {}

  void run() {
    planner::RayScheduler& scheduler = rays_.scheduler();
    if (!scheduler.usable()) return fault("is not usable");
    for (std::uint32_t task = 0; task < 2; ++task) {
      const std::uint32_t passed =
          task == 0 ? planner::RayScheduler::kNothingPassed : static_cast<std::uint32_t>(rays_.draw(3));
      if (scheduler.begin(rays_.view(), rays_.poses(), passed) != Status::ok) return fault("was refused");
      const RayTwin twin(scheduler, rays_.view(), rays_.poses());
      const double seed_worth = twin.worth(chosen_rows(scheduler));
      spend(twin, seed_worth);
      if (!scheduler.done()) return fault("has no end");
      judge(twin, seed_worth);
      if (!rays_.one_of(4)) break;
    }
    budget();
  }

 private:
  void fault(const std::string& what) {
    if (tally_->faults.size() < 20) tally_->faults.push_back(std::to_string(seed_) + " " + what);
  }
  void check(bool good, const char* what) {
    if (!good) fault(what);
  }
  // Each entry in the table rounds what is left of a cell to a float, once: half of 2^-23.
  double noise() const {
    const planner::RayPlan& plan = rays_.scheduler().plan();
    return 0x1p-23 * (1.0 + plan.positions * plan.rays);
  }

  // To the end in slices. Plans are whole, their worth never falls, no unit is spent that was not given.
  void spend(const RayTwin& twin, double before) {
    planner::RayScheduler& scheduler = rays_.scheduler();
    const std::uint64_t way = rays_.draw(3);
    tally_->single += way == 0 ? 1 : 0;
    std::uint64_t given = 0;
    std::uint64_t spent = 0;
    std::uint64_t digest = 0;
    for (int i = 0; i < 20'000'000 && !scheduler.done(); ++i) {
      const std::uint64_t slice = way == 0 ? 1 : way == 1 ? rays_.draw(2000) : UINT64_MAX;
      given += std::min(slice, UINT64_MAX - given);
      const std::uint64_t cost = scheduler.step(slice);
      spent += cost;
      check(spent <= given, "spends what it was not given");
      if (way == 0) {  // one step at the most
        const auto largest = static_cast<double>(scheduler.largest_step());
        tally_->dearest = std::max(tally_->dearest, static_cast<double>(cost) / largest);
        check(cost <= scheduler.largest_step(), "has a step that is dearer than the dearest");
      }
      if (scheduler.plan().digest == digest) continue;
      digest = scheduler.plan().digest;
      check(is_valid_plan(scheduler), "is no valid plan");
      const double worth = twin.worth(chosen_rows(scheduler));
      check(worth >= before * (1 - noise()), "is worth less for more units");
      before = worth;
    }
    check(scheduler.plan().units == spent, "says that other units were spent");
  }

  void judge(const RayTwin& twin, double seed_worth) {
    const planner::RayScheduler& scheduler = rays_.scheduler();
    const planner::RaySchedulerConfig& config = rays_.config();
    const planner::RayPlan& plan = scheduler.plan();
    const double worth = twin.worth(chosen_rows(scheduler));
    const bool all = config.rays >= config.sensor.rays();
    const bool has_exact = config.exact && !all && config.rays > 0;
    const RayTwin::Choice greedy = twin.greedy(SIZE_MAX);
    const RayTwin::Choice fitting =
        twin.greedy(config.table_lines > 0 ? config.table_lines : std::size_t{32768});
    const double greedy_worth = twin.worth(greedy.rows);
    check(plan.worth <= worth * (1 + noise()), "says a worth that it has not");
    if (plan.exact_worth) check(plan.worth >= worth * (1 - noise()), "says a worth as if it were exact");
    if (plan.stage == planner::RayStage::exact)
      check(begins_with(scheduler, fitting.rows), "is not what plain greedy chooses");
    else if (has_exact && !plan.table_full)
      check(worth >= greedy_worth * (1 - 1e-6 - 2 * noise()), "kept a plan that is worth less");
    if (fitting.refused && has_exact) check(plan.table_full, "hides that its table was full");
    tally_->exact += plan.stage == planner::RayStage::exact ? 1 : 0;
    tally_->full += plan.table_full ? 1 : 0;
    tally_->all_taken += all ? 1 : 0;
    tally_->worthless += greedy.rows.empty() ? 1 : 0;
    check(std::isfinite(plan.best_bound) == (config.rays == 0 || all || (has_exact && config.certify)),
          "has a bound where there is none, or none where there is one");
    if (!std::isfinite(plan.best_bound))
      return check(plan.certificate == 0.0, "has a certificate of nothing");
    ++tally_->certified;
    tally_->full_certified += plan.table_full ? 1 : 0;
    const double best = twin.best_of_all();
    tally_->tried_all += best > 0 ? 1 : 0;
    const double known = std::max({worth, seed_worth, greedy_worth, best});
    check(plan.best_bound * (1 + noise()) >= known, "has a bound below a plan");
    check(plan.certificate * known <= worth * (1 + 2 * noise()) || !(known > 0), "has a false certificate");
    if (plan.table_full || config.rays == 0) return;
    // No part of the bound was given away.
    const double again = all ? worth : twin.bound(greedy.rows);
    check(std::fabs(plan.best_bound - again) <= again * (1e-6 + 2 * noise()), "has another bound");
  }

  // A budget is kept, and how it is sliced changes nothing.
  void budget() {
    planner::RayScheduler& scheduler = rays_.scheduler();
    const std::uint64_t units = rays_.draw(2 * scheduler.plan().units + 1000);
    (void)scheduler.begin(rays_.view(), rays_.poses());
    check(scheduler.step(units) <= units, "spends more than its budget");
    const std::uint64_t digest = rt::digest_of(scheduler.plan());
    (void)scheduler.begin(rays_.view(), rays_.poses());
    for (std::uint64_t given = 0; given < units;) {
      const std::uint64_t slice = std::min(units - given, rays_.draw(500));
      given += slice;
      (void)scheduler.step(slice);
    }
    check(rt::digest_of(scheduler.plan()) == digest, "depends on slices");
  }

  std::uint64_t seed_;
  RandomTally* tally_;
  mutable RandomRays rays_;
};

inline RandomTally judge_random_rays(std::uint64_t first, std::uint64_t last) {
  RandomTally tally;
  for (std::uint64_t seed = first; seed < last; ++seed) RandomJudge(seed, tally).run();
  return tally;
}

}  // namespace sortie::tests
