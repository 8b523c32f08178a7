// SPDX-License-Identifier: BSD-3-Clause
// A recorded lidar that is carried about, cut at a scan: one part is kept, the other one is another robot's.
#include <algorithm>
#include <string>

#include "tests/bench/recognition/look_figures.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/recognition/recognition_trials.hpp"
#include "tests/bench/report/parts.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {
namespace {

using mapping::SetVerdict;
using Scans = std::vector<HallScan>;

constexpr int kCuts = 5;
constexpr double kLook_m = 0.5;

Scans read_scans(const std::string& data) {
  Scans out;
  for (tests::RecordedScan& scan : tests::read_rls(data + "/lidar_os64/os64_thin4_000_109.rls")) {
    const mapping::SensorPose pose = scan.pose();
    out.push_back({std::move(scan.points), {pose.p_world_sensor_m, pose.q_world_sensor}});
  }
  return out;
}

double way_of(const Scans& scans) {
  double way_m = 0.0;
  for (std::size_t i = 1; i < scans.size(); ++i) way_m += rt::norm(scans[i].pose.p - scans[i - 1].pose.p);
  return way_m;
}

/// Looks of one or of many trials.
struct LookTally {
  int looks{}, found_right{}, found_wrong{}, placed_right{}, placed_wrong{}, confirmed{}, confirmed_wrong{};
  int by[static_cast<int>(SetVerdict::undecided) + 1]{};
  Rounds speaking, kept, asked_right, found_m, found_deg, placed_m, placed_deg, first_found_m, first_placed_m;

  void add(const RecognitionTrial& trial) {
    bool has_found = false, has_placed = false;
    for (const RecognitionLook& look : trial.looks) {
      ++looks;
      ++by[static_cast<int>(look.segments)];
      speaking.add(look.speaking);
      kept.add(look.kept);
      asked_right.add(look.asked_right);
      if (look.found) {
        ++(look.found->is_right() ? found_right : found_wrong);
        if (look.found->is_right()) {
          if (!has_found) first_found_m.add(look.way_m);
          has_found = true;
          found_m.add(look.found->move_m);
          found_deg.add(look.found->turn_deg);
        }
      }
      if (!look.placed) continue;
      ++(look.placed->is_right() ? placed_right : placed_wrong);
      if (look.confirmed) ++(look.placed->is_right() ? confirmed : confirmed_wrong);
      if (!look.placed->is_right()) continue;
      if (!has_placed) first_placed_m.add(look.way_m);
      has_placed = true;
      placed_m.add(look.placed->move_m);
      placed_deg.add(look.placed->turn_deg);
    }
  }
  int verdicts(SetVerdict verdict) const { return by[static_cast<int>(verdict)]; }
};

Json row(const std::string& kept, const std::string& now, double way_m, Json targets,
         const LookTally& tally) {
  return {kept,
          now,
          std::round(10 * way_m) / 10,
          std::move(targets),
          median(tally.speaking),
          median(tally.kept),
          median(tally.asked_right),
          tally.looks,
          tally.found_right,
          tally.found_wrong,
          tally.verdicts(SetVerdict::few),
          tally.verdicts(SetVerdict::inconsistent),
          tally.verdicts(SetVerdict::ambiguous),
          tally.verdicts(SetVerdict::bent),
          tally.verdicts(SetVerdict::narrow),
          median(tally.first_found_m),
          tally.placed_right,
          tally.placed_wrong,
          median(tally.first_placed_m),
          tally.confirmed,
          tally.confirmed_wrong,
          rms(tally.found_m),
          rms(tally.found_deg),
          rms(tally.placed_m),
          rms(tally.placed_deg)};
}

}  // namespace

void measure_recognition_visits(const RecognitionSettings& settings, Report& report) {
  const Scans scans = read_scans(settings.data);
  if (scans.empty()) return report.skip("recorded visits", "lidar_os64 is not in " + settings.data);
  const int cuts = settings.cases_or(kCuts);
  Json rows = Json::array();
  LookTally all;
  int trials = 0;
  testing::Draws draws(settings.seed);
  TrialConfig config;
  config.look_m = kLook_m;
  config.every = 1;  // two a second are few enough
  double way_m = 0.0;
  for (int c = 0; c < cuts; ++c) {
    // Between a third and three quarters: it stood still at first.
    const auto count = static_cast<double>(scans.size());
    const double share = cuts > 1 ? 1.0 / 3 + (0.75 - 1.0 / 3) * c / (cuts - 1) : 0.5;
    const auto cut = static_cast<std::ptrdiff_t>(share * count);
    const Scans parts[2] = {{scans.begin(), scans.begin() + cut}, {scans.begin() + cut, scans.end()}};
    for (const int kept : {0, 1}) {
      for (const bool reversed : {false, true}) {
        Scans now = parts[1 - kept];
        if (reversed) std::reverse(now.begin(), now.end());
        const RecognitionTrial trial = try_scans(parts[kept], now, config, draws);
        LookTally tally;
        tally.add(trial);
        all.add(trial);
        ++trials;
        const double now_m = way_of(now);
        way_m += now_m;
        const auto named = [&](int part) {
          return part == 0 ? "scans before " + std::to_string(cut) : "scans from " + std::to_string(cut);
        };
        rows.push_back(row(named(kept), named(1 - kept) + (reversed ? ", last first" : ""), now_m,
                           trial.targets, tally));
      }
    }
  }
  rows.push_back(row("all", "", way_m, "", all));
  Figure figure;
  figure.group = "visits";
  figure.what = "looks in which segments find a wrong place";
  figure.n = static_cast<std::uint64_t>(all.looks);
  figure.ours = spread(all.found_wrong);
  report.add(figure);
  figure.what = "looks in which a scan places the robot wrongly";
  figure.ours = spread(all.placed_wrong);
  set_goal(figure, "none", all.placed_wrong == 0);
  report.add(figure);
  report.add_table("visits",
                   {"kept",
                    "second visit",
                    "its way, m",
                    "targets",
                    "segments that speak",
                    "looks",
                    "found by segments",
                    "wrongly",
                    "few",
                    "inconsistent",
                    "ambiguous",
                    "other reasons",
                    "first right one after, m",
                    "a scan fits there",
                    "wrongly",
                    "first right one after, m",
                    "two looks",
                    "wrongly",
                    "segments off, m",
                    "deg",
                    "scan off, m",
                    "deg"},
                   rows);
  report.note("visits",
              std::to_string(trials) +
                  " trials of one recording (lidar_os64: 110 scans, 40 m of way, carried by hand), a "
                  "look each half metre. Wrong: more than 1 m or 5 degrees off. Errors are RMS of "
                  "the right ones. The second visit's frame is turned and moved by chance, seed " +
                  std::to_string(settings.seed) + ".");
}

}  // namespace sortie::bench
