// SPDX-License-Identifier: BSD-3-Clause
// Robots lost on a kept map: how many are placed, over the work that it takes.
#include <algorithm>
#include <memory>
#include <stdexcept>

#include "tests/bench/registration/hall_case.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/front.hpp"
#include "tests/mapping/place_trials.hpp"

namespace sortie::bench {
namespace {

constexpr int kRobotsOfBuilding = 8;

struct Knobs {
  const char* curve;
  mapping::PlaceSearchConfig search;
  std::uint32_t first_returns;
  Rounds ms{}, units{};
  int right{}, wrong{};
};

std::vector<Knobs> all_knobs() {
  const mapping::PlaceSearchConfig usual;
  const std::uint32_t first = mapping::RelocateConfig{}.first_returns;
  std::vector<Knobs> all{{"defaults", usual, first}};
  for (const std::uint32_t returns : {48u, 64u, 96u}) {
    all.push_back({"returns", usual, first});
    all.back().search.returns = returns;
  }
  for (const std::uint32_t candidates : {4u, 12u, 24u, 64u}) {
    all.push_back({"candidates", usual, first});
    all.back().search.candidates = candidates;
  }
  for (const double reach_m : {6.0, 10.0, 40.0}) {
    all.push_back({"reach", usual, first});
    all.back().search.reach_m = reach_m;
  }
  for (const std::uint32_t returns : {64u, 1024u}) {
    all.push_back({"first matched with", usual, returns});
  }
  return all;
}

std::string label_of(const Knobs& knobs) {
  const std::string name = knobs.curve;
  if (name == "returns") return std::to_string(knobs.search.returns);
  if (name == "candidates") return std::to_string(knobs.search.candidates);
  if (name == "reach") return decimals(knobs.search.reach_m, 0) + " m";
  return std::to_string(knobs.first_returns);
}

/// A relocaliser of its own on the rig's map.
struct Seeker {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::Relocaliser part;

  Seeker(testing::PlaceRig& rig, const Knobs& knobs, const mapping::RelocateConfig& config)
      : memory(std::size_t{128} << 20),
        arena(memory),
        part(config, knobs.search, testing::kSiteMemory, rig.registration, arena) {
    if (arena.refused() != 0 || !part.take_map()) throw std::runtime_error("lost: no room for the map");
  }
};

struct Lost {
  testing::LostRobot robot;
  std::vector<rt::ScanPoint> scan;
};

void seek(Knobs& knobs, testing::PlaceRig& rig, const std::vector<Lost>& robots) {
  mapping::RelocateConfig config;
  config.first_returns = knobs.first_returns;
  const auto owned = std::make_unique<Seeker>(rig, knobs, config);
  mapping::Relocaliser& part = owned->part;
  for (const Lost& lost : robots) {
    rig.registration.take(lost.scan);
    const double begin = step_cpu_ms();
    part.begin(rig.registration.sample(), lost.robot.q_level_sensor);
    std::uint64_t units = ~std::uint64_t{0} >> 1;
    (void)part.run(units);
    knobs.ms.add(step_cpu_ms() - begin);
    const mapping::Relocated& found = part.result();
    knobs.units.add(1e-6 * static_cast<double>(found.units));
    if (found.verdict != mapping::RelocateVerdict::placed) continue;
    ++(lost.robot.is_right(found.T_map_sensor) ? knobs.right : knobs.wrong);
  }
}

}  // namespace

void measure_registration_lost(const RegistrationSettings& settings, Report& report) {
  const int robots = settings.cases_or(32);
  std::vector<Knobs> all = all_knobs();
  testing::PlaceRig rig(testing::kSiteMemory);
  for (int done = 0; done < robots; done += kRobotsOfBuilding) {
    testing::Draws draws(settings.seed + static_cast<std::uint64_t>(done));
    const testing::PlaceWorld world = testing::random_building(draws, 50, 20, 1);
    rig.make_map(world, draws, 2.5);
    std::vector<Lost> lost;
    for (int i = 0; i < std::min(kRobotsOfBuilding, robots - done); ++i) {
      testing::LostRobot robot(world, draws);
      std::vector<rt::ScanPoint> scan = testing::scan_where_known(rig, world, draws, 0.9, robot);
      lost.push_back({robot, std::move(scan)});
    }
    for (Knobs& knobs : all) seek(knobs, rig, lost);
  }
  std::vector<FrontCell> cells;
  for (const Knobs& knobs : all) {
    FrontCell cell;
    cell.curve = knobs.curve;
    cell.label = label_of(knobs);
    cell.by_itself = cell.curve == "defaults";
    cell.cost = knobs.ms.median();
    cell.error = 100.0 * (1.0 - knobs.right / static_cast<double>(robots));
    cell.row = {knobs.search.returns,
                knobs.search.candidates,
                decimals(knobs.search.reach_m, 0),
                knobs.first_returns,
                robots,
                knobs.right,
                knobs.wrong,
                decimals(knobs.units.median(), 1),
                decimals(knobs.units.high(), 1),
                decimals(knobs.ms.median(), 0),
                decimals(knobs.ms.high(), 0)};
    cells.push_back(cell);
  }
  const Picture picture{"bench-registration-lost",
                        "lost",
                        "Robots lost on a kept map: not placed, over run time",
                        "run time of a search, median, ms",
                        "not placed, %",
                        true,
                        false,
                        false,
                        {}};
  add_front(report, picture,
            {"returns", "candidates", "reach m", "first matched with", "n", "placed", "wrong",
             "M units median", "most", "ms median", "max"},
            cells, FrontRows::all);
  report.note("lost",
              "Buildings of one storey, 50 x 20 m, of which the map knows nine tenths of what a scan sees; "
              "lidars of 16, 32 and 64 rows; nothing known but the attitude, to half a degree. One knob at a "
              "time.");
}

}  // namespace sortie::bench
