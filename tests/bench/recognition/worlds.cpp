// SPDX-License-Identifier: BSD-3-Clause
// Whole worlds: those that are built to deceive, and halls that are visited twice.
#include <algorithm>
#include <string>

#include "tests/bench/recognition/look_figures.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/recognition/recognition_trials.hpp"

namespace sortie::bench {
namespace {

constexpr int kWorlds = 20;         ///< of a kind
constexpr int kRevisits = 4;        ///< of a row
constexpr int kEvidenceWorlds = 8;  ///< of a kind; of halls a quarter

/// Trials in which a place was told, and in which any that was told is wrong.
struct Told {
  int right{}, wrong{};
  void add(bool any_right, bool any_wrong) {
    right += any_right && !any_wrong ? 1 : 0;
    wrong += any_wrong ? 1 : 0;
  }
};

struct TrialTally {
  int worlds{}, kept{};
  Told found, placed, confirmed;                    ///< by segments; by one scan, too; by two looks
  int placed_wrong_kept{};                          ///< of placed.wrong, where the place was kept
  int ambiguous{};                                  ///< segments said so in the last look
  Rounds way_m;                                     ///< until a scan was placed rightly for the first time
  Rounds found_m, found_deg, placed_m, placed_deg;  ///< off, in that look
  std::string wrong_seeds;

  void add(const RecognitionTrial& trial, std::uint64_t seed) {
    ++worlds;
    kept += trial.is_kept ? 1 : 0;
    bool right[3]{}, wrong[3]{};
    for (const RecognitionLook& look : trial.looks) {
      const auto note = [&](int i, const std::optional<PoseError>& told) {
        if (!told) return;
        (trial.is_kept && told->is_right() ? right[i] : wrong[i]) = true;
      };
      if (look.placed && look.placed->is_right() && look.found && trial.is_kept && !right[1]) {
        way_m.add(look.way_m);
        found_m.add(look.found->move_m);
        found_deg.add(look.found->turn_deg);
        placed_m.add(look.placed->move_m);
        placed_deg.add(look.placed->turn_deg);
      }
      note(0, look.found);
      note(1, look.placed);
      if (look.confirmed) note(2, look.placed);
    }
    found.add(right[0], wrong[0]);
    placed.add(right[1], wrong[1]);
    placed_wrong_kept += trial.is_kept && wrong[1] ? 1 : 0;
    confirmed.add(right[2], wrong[2]);
    if (!trial.looks.empty() && trial.looks.back().segments == mapping::SetVerdict::ambiguous) ++ambiguous;
    if (wrong[1]) wrong_seeds += " " + std::to_string(seed) + (wrong[2] ? "!" : "");
  }
  int within(double most_m) const {
    int count = 0;
    for (const double way : way_m.values()) count += way <= most_m ? 1 : 0;
    return count;
  }
};

}  // namespace

void measure_recognition_deceive(const RecognitionSettings& settings, Report& report) {
  const int worlds = settings.cases_or(kWorlds);
  Json rows = Json::array();
  Told placed, confirmed;
  for (const Deception kind : kDeceptions) {
    TrialTally tally;
    for (int i = 0; i < worlds; ++i) {
      const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
      testing::Draws draws(seed);
      const RecognitionWorld world = deceptive_world(kind, draws);
      tally.add(try_recognition(world, {}, draws), seed);
    }
    rows.push_back({name_of(kind), tally.worlds, tally.kept, tally.found.right, tally.found.wrong,
                    tally.ambiguous, tally.placed.right, tally.placed.wrong, tally.placed_wrong_kept,
                    tally.confirmed.right, tally.confirmed.wrong});
    placed.wrong += tally.placed.wrong;
    confirmed.wrong += tally.confirmed.wrong;
    if (!tally.wrong_seeds.empty())
      report.note("deceive", std::string(name_of(kind)) +
                                 ": one look placed the robot wrongly in worlds (!: two looks, too)" +
                                 tally.wrong_seeds + ".");
  }
  Figure figure;
  figure.group = "deceive";
  figure.what = "worlds in which two looks place a lost robot wrongly";
  figure.n = static_cast<std::uint64_t>(worlds) * std::size(kDeceptions);
  figure.ours = spread(confirmed.wrong);
  set_goal(figure, "none", confirmed.wrong == 0);
  report.add(figure);
  figure.what = "worlds in which one look does";
  figure.ours = spread(placed.wrong);
  figure.goal.clear();
  figure.met = nullptr;
  report.add(figure);
  report.add_table(
      "deceive",
      {"worlds", "n", "of these kept", "found by segments, rightly", "wrongly", "ambiguous",
       "placed by one look, rightly", "wrongly", "of these kept", "by two looks, rightly", "wrongly"},
      rows);
  report.note(
      "deceive",
      "Seeds " + std::to_string(settings.seed) + " to " +
          std::to_string(settings.seed + static_cast<std::uint64_t>(worlds) - 1) +
          " of each kind. Kept: both places that look alike, or the one pattern that the robot is in; in "
          "the others it is where nothing was kept. Wrong: more than 1 m or 5 degrees off, or any place "
          "where nothing was kept. A world counts as wrong where any look along the way is.");
}

void measure_recognition_revisits(const RecognitionSettings& settings, Report& report) {
  struct Kind {
    const char* name;
    SecondWay way;
    double moved;
  };
  constexpr Kind kKinds[] = {{"same direction", SecondWay::along, 0.0},
                             {"opposite", SecondWay::against, 0.0},
                             {"same direction, 30 % of the things moved", SecondWay::along, 0.3}};
  const int halls = settings.cases_or(kRevisits);
  Json rows = Json::array();
  for (const Kind& kind : kKinds) {
    for (const double radius_m : {5.0, 10.0, 20.0, 40.0}) {
      TrialTally tally;
      for (int i = 0; i < halls; ++i) {
        const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
        testing::Draws draws(seed);
        const RecognitionWorld world = revisited_hall(kind.way, kind.moved, draws);
        TrialConfig config;
        config.radius_m = radius_m;
        config.sparse = false;
        config.most_way_m = 15.0;
        tally.add(try_recognition(world, config, draws), seed);
      }
      rows.push_back({kind.name, radius_m, tally.worlds, tally.found.right, tally.found.wrong,
                      tally.placed.right, tally.placed.wrong, tally.within(3.0), tally.within(6.0),
                      tally.confirmed.right, tally.confirmed.wrong, median(tally.way_m), rms(tally.found_m),
                      rms(tally.found_deg), rms(tally.placed_m), rms(tally.placed_deg)});
    }
  }
  report.add_table("revisits",
                   {"second visit", "local map, m", "n", "found by segments", "wrongly", "placed by one look",
                    "wrongly", "within 3 m", "6 m", "by two looks", "wrongly", "way, m (median)",
                    "segments off, m", "deg", "scan off, m", "deg"},
                   rows);
  report.note("revisits", "Seeds " + std::to_string(settings.seed) + " to " +
                              std::to_string(settings.seed + static_cast<std::uint64_t>(halls) - 1) +
                              " of each row; 15 m of way. Errors are RMS, in the first look that placed "
                              "the robot rightly.");
}

void measure_recognition_evidence(const RecognitionSettings& settings, Report& report) {
  const int worlds = settings.cases_or(kEvidenceWorlds), halls = std::max(worlds / 4, 1);
  Json rows = Json::array();
  for (const double over : {1.0, 1.5, 2.0, 3.0}) {
    TrialTally deceived, revisited;
    TrialConfig config;
    config.judge.over_unexplained = over;
    for (int i = 0; i < worlds; ++i) {
      const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
      for (const Deception kind : {Deception::rooms, Deception::floors}) {
        testing::Draws draws(seed);
        const RecognitionWorld world = deceptive_world(kind, draws);
        deceived.add(try_recognition(world, config, draws), seed);
      }
    }
    config.radius_m = 10.0;
    config.sparse = false;
    config.most_way_m = 18.0;
    for (int i = 0; i < halls; ++i) {
      const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
      testing::Draws draws(seed);
      const RecognitionWorld world = revisited_hall(SecondWay::along, 0.3, draws);
      revisited.add(try_recognition(world, config, draws), seed);
    }
    rows.push_back({over, deceived.worlds, deceived.placed.wrong, deceived.confirmed.wrong, revisited.worlds,
                    revisited.placed.right, revisited.confirmed.right});
  }
  report.add_table("evidence",
                   {"over_unexplained", "worlds", "one look wrongly", "two looks", "halls",
                    "one look rightly", "two looks"},
                   rows);
  report.note("evidence",
              "Worlds: rooms and storeys that are built to deceive. Halls: visited again in the same "
              "direction with 30 % of the things moved, local map 10 m, 18 m of way. Seeds from " +
                  std::to_string(settings.seed) + ".");
}

}  // namespace sortie::bench
