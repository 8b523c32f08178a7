// SPDX-License-Identifier: BSD-3-Clause
// Recall and false places over run time: what a search by segments gives, by what it may spend and asks for.
#include <algorithm>
#include <set>
#include <string>

#include "tests/bench/recognition/kept_building.hpp"
#include "tests/bench/recognition/owned_sets.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/report/front.hpp"

#include "mapping/registration/pose_algebra.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;

constexpr int kHalls = 24, kWorldsOfAKind = 8;

/// One choice of settings: what is not said is as by itself.
struct SearchKnob {
  std::string name, value;
  RecogniserConfig config;
  std::uint32_t targets{TargetStoreConfig{}.targets};
};

std::vector<SearchKnob> all_knobs() {
  std::vector<SearchKnob> all{{"defaults", "", {}}};
  const auto add = [&all](const char* name, const std::string& value) -> SearchKnob& {
    all.push_back({name, value, {}});
    return all.back();
  };
  for (const std::uint32_t units : {300'000u, 600'000u, 1'000'000u, 2'000'000u, 5'000'000u})
    add("most_units", decimals(1e-6 * units, 1) + " M").config.most_units = units;
  for (const std::uint32_t most : {1u, 2u, 4u, 8u, 32u}) {
    SearchKnob& knob = add("candidates", std::to_string(most));
    knob.config.candidates.most = most;
    knob.config.pairs = std::max(1024u, 64 * most);
  }
  for (const std::uint32_t steps : {8u, 32u, 255u})
    add("size_steps", std::to_string(steps)).config.candidates.size_steps = steps;
  for (const std::uint32_t segments : {16u, 32u, 128u}) {
    SearchKnob& knob = add("limits.speaking", std::to_string(segments));
    knob.config.segments = segments;
    knob.config.pairs = std::max(1024u, 16 * segments);
  }
  for (const std::uint32_t targets : {512u, 1024u, 2048u})
    add("limits.targets", std::to_string(targets)).targets = targets;
  add("gravity", "false").config.set.gravity = false;
  for (const std::uint32_t least : {4u, 5u, 8u, 10u, 12u})
    add("least", std::to_string(least)).config.set.least = least;
  for (const double eps_m : {0.1, 0.2, 0.8}) add("eps_m", decimals(eps_m, 1)).config.set.eps_m = eps_m;
  for (const double of_rival : {0.4, 0.8, 1.0})
    add("of_rival", decimals(of_rival, 1)).config.set.of_rival = of_rival;
  return all;
}

/// What all looks came to.
struct SearchTally {
  Rounds ms, units;
  int looks{}, right{}, wrong{};                                             ///< in halls
  int undecided{};                                                           ///< anywhere
  std::set<std::size_t> recognised, deceived, deceptive_right, halls_wrong;  ///< worlds
};

SearchTally search_all(const SearchKnob& knob, const KeptBuilding& building) {
  TrialMemory memory(8);
  Recogniser recogniser(knob.config, memory.arena);
  memory.check();
  const TargetStore& store = building.store(knob.targets);
  SearchTally tally;
  for (const BuildingLook& look : building.looks()) {
    const std::size_t count = std::min<std::size_t>(look.segments.size(), knob.config.segments);
    const std::uint64_t given = ~std::uint64_t{0} >> 1;
    std::uint64_t units = given;
    const double begin = set_cpu_ms();
    recogniser.begin({look.segments.data(), count}, {});
    (void)recogniser.run(store, units);
    tally.ms.add(set_cpu_ms() - begin);
    tally.units.add(1e-6 * static_cast<double>(given - units));
    tally.looks += look.is_hall ? 1 : 0;
    tally.undecided += recogniser.verdict() == SetVerdict::undecided ? 1 : 0;
    if (recogniser.verdict() != SetVerdict::found) continue;
    const RigidPose told = after(pose_of(recogniser.found()[0].fit.place), look.odom);
    const bool right = look.is_kept && error_of(told, look.truth).is_right();
    if (look.is_hall) {
      ++(right ? tally.right : tally.wrong);
      (right ? tally.recognised : tally.halls_wrong).insert(look.world);
    } else {
      (right ? tally.deceptive_right : tally.deceived).insert(look.world);
    }
  }
  return tally;
}

/// Not recognised over worlds that deceive.
void add_false_picture(const std::vector<FrontCell>& cells, const std::vector<double>& deceived,
                       Report& report) {
  Picture picture{"bench-recognition-sweep-false",
                  "sweep",
                  "Worlds that deceive over looks in halls that do not recognise, by segments alone",
                  "looks in halls that are not recognised, %",
                  "worlds built to deceive in which a place is wrong, %",
                  false,
                  false,
                  false,
                  {}};
  Curve defaults;
  defaults.style = "default";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Curve* curve = &defaults;
    if (!cells[i].by_itself) {
      if (picture.curves.empty() || picture.curves.back().name != cells[i].curve) {
        picture.curves.emplace_back();
        picture.curves.back().name = cells[i].curve;
        picture.curves.back().style = "dots";
      }
      curve = &picture.curves.back();
    }
    curve->x.push_back(cells[i].error);
    curve->y.push_back(deceived[i]);
    curve->labels.push_back(cells[i].by_itself ? "defaults" : cells[i].label);
  }
  picture.curves.push_back(defaults);
  add_picture(report, picture);
}

}  // namespace

void measure_recognition_sweep(const RecognitionSettings& settings, Report& report) {
  const int worlds = settings.cases_or(kWorldsOfAKind);
  const KeptBuilding building(settings.cases > 0 ? 3 * worlds : kHalls, worlds, settings.seed);
  std::vector<FrontCell> cells;
  std::vector<double> deceived;
  const double halls = static_cast<double>(building.halls());
  const double deceptive = static_cast<double>(building.deceptive());
  for (const SearchKnob& knob : all_knobs()) {
    const SearchTally tally = search_all(knob, building);
    const double looks = std::max(tally.looks, 1);
    FrontCell cell;
    cell.curve = knob.name;
    cell.label = knob.value;
    cell.by_itself = knob.name == "defaults";
    cell.cost = tally.ms.quantile(0.99);
    cell.error = 100.0 * (1.0 - tally.right / looks);
    deceived.push_back(100.0 * static_cast<double>(tally.deceived.size()) / deceptive);
    cell.row = {knob.name,
                knob.value,
                decimals(100.0 * tally.right / looks, 1),
                decimals(100.0 * tally.wrong / looks, 1),
                decimals(100.0 * static_cast<double>(tally.recognised.size()) / halls, 0),
                tally.halls_wrong.size(),
                tally.deceptive_right.size(),
                tally.deceived.size(),
                tally.undecided,
                decimals(tally.units.median(), 2),
                decimals(tally.units.high(), 2),
                decimals(tally.ms.median(), 2),
                decimals(tally.ms.quantile(0.99), 2),
                decimals(tally.ms.high(), 2)};
    cells.push_back(cell);
  }
  const Picture picture{"bench-recognition-sweep",
                        "sweep",
                        "Looks in halls that are not recognised by segments, over run time",
                        "run time of a search, 99 % are below, ms",
                        "not recognised, %",
                        true,
                        false,
                        false,
                        {}};
  add_front(
      report, picture,
      {"knob", "value", "looks in halls, right %", "wrong %", "halls recognised, %", "halls, wrong",
       "deceptive worlds, right", "wrong", "undecided", "M units median", "most", "ms median", "p99", "max"},
      cells, FrontRows::all);
  add_false_picture(cells, deceived, report);
  report.note(
      "sweep",
      std::to_string(building.halls()) + " halls that are visited twice and " +
          std::to_string(building.deceptive()) + " worlds that are built to deceive in one store of " +
          std::to_string(building.store(TargetStoreConfig{}.targets).kept()) + " targets; " +
          std::to_string(building.looks().size()) +
          " looks, one every 2 m of the first 15 m of a second visit. By segments alone: no scan is asked. "
          "One knob at a time; front: by run time and looks in halls. A world counts as right or wrong "
          "where any look is.");
}

}  // namespace sortie::bench
