// SPDX-License-Identifier: BSD-3-Clause
// Long recorded drives through made-up towns: precision and recall where the way comes back.
#include <cmath>
#include <string>

#include "tests/bench/recognition/look_figures.hpp"
#include "tests/bench/recognition/loop_tally.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/report/picture.hpp"

namespace sortie::bench {
namespace {

using mapping::SetVerdict;

constexpr double kStep_m = 0.5;
constexpr int kHundreds = 12;  ///< of metres of a drive, at most
constexpr double kDeg = M_PI / 180.0;
constexpr HallLidar kLidar{64, 256, -22.5 * kDeg, 22.5 * kDeg, 0.02};

constexpr const char* kBeliefs[] = {"segments", "and a scan"};

void add_rows(const std::string& name, const LoopTallies& tallies, Json& rows) {
  for (int i = 0; i < 2; ++i) {
    const LoopTally& tally = tallies.by[i];
    const Revisits& revisits = tally.revisits;
    rows.push_back({name, std::round(tally.way_m), kBeliefs[i], revisits.all, revisits.recognised,
                    revisits.within_3m, median(revisits.way_m), tally.on_revisit.looks,
                    tally.on_revisit.recall(), tally.all.right, tally.all.wrong, tally.all.precision(),
                    tally.per_km(tally.all.right), tally.per_km(tally.all.wrong), rms(tally.off_m),
                    rms(tally.off_deg)});
  }
}

/// Recall and precision by the distance to the nearest place that was kept.
void add_by_distance(const LoopTallies& tallies, Report& report) {
  Picture picture;
  picture.file = "bench-recognition-loops-distance";
  picture.group = "loops";
  picture.title = "Looks on long drives, by distance to where the robot was before";
  picture.x = "distance, m";
  picture.y = "%";
  Json rows = Json::array();
  for (int b = 0; b <= kLoopBins; ++b) {
    Json row = Json::array({b, tallies.by[0].bins[b].looks});
    for (const LoopTally& tally : tallies.by) {
      const Asked& bin = tally.bins[b];
      for (const Json& cell : {Json(bin.right), Json(bin.wrong), bin.recall(), bin.precision()})
        row.push_back(cell);
    }
    rows.push_back(row);
  }
  for (int i = 0; i < 2; ++i) {
    Curve recall, precision;
    recall.name = std::string("recall, ") + kBeliefs[i];
    precision.name = std::string("precision, ") + kBeliefs[i];
    recall.colour = precision.colour = i;
    precision.style = "dashed";
    for (int b = 0; b < kLoopBins; ++b) {
      const Asked& bin = tallies.by[i].bins[b];
      if (bin.looks == 0) continue;
      recall.x.push_back(b + 0.5);
      recall.y.push_back(100.0 * bin.right / bin.looks);
      if (bin.right + bin.wrong == 0) continue;
      precision.x.push_back(b + 0.5);
      precision.y.push_back(100.0 * bin.right / (bin.right + bin.wrong));
    }
    picture.curves.push_back(recall);
    picture.curves.push_back(precision);
  }
  add_picture(report, picture);
  report.add_table("loops",
                   {"nearest kept place, from m", "looks", "segments: right", "wrong", "recall, %",
                    "precision, %", "and a scan: right", "wrong", "recall, %", "precision, %"},
                   rows);
}

/// Precision over recall, by the least segments that agree.
void add_by_set(const LoopTallies& tallies, Report& report) {
  Picture picture;
  picture.file = "bench-recognition-loops-sets";
  picture.group = "loops";
  picture.title = "Within 5 m of where the robot was, by the least segments that agree";
  picture.x = "recall, %";
  picture.y = "precision, %";
  Json rows = Json::array();
  for (std::size_t s = 0; s < std::size(kLoopSets); ++s) {
    Json row = Json::array({kLoopSets[s]});
    for (const LoopTally& tally : tallies.by) {
      const Asked& set = tally.sets[s];
      for (const Json& cell : {Json(set.right), Json(set.wrong),
                               Asked::share(set.right, tally.on_revisit.looks), set.precision()})
        row.push_back(cell);
    }
    rows.push_back(row);
  }
  for (int i = 0; i < 2; ++i) {
    Curve curve;
    curve.name = kBeliefs[i];
    for (std::size_t s = 0; s < std::size(kLoopSets); ++s) {
      const Asked& set = tallies.by[i].sets[s];
      if (set.right + set.wrong == 0 || tallies.by[i].on_revisit.looks == 0) continue;
      curve.x.push_back(100.0 * set.right / tallies.by[i].on_revisit.looks);
      curve.y.push_back(100.0 * set.right / (set.right + set.wrong));
      curve.labels.push_back(std::to_string(kLoopSets[s]));
    }
    picture.curves.push_back(curve);
  }
  add_picture(report, picture);
  report.add_table(
      "loops",
      {"segments that agree, at least", "right within 5 m", "wrong anywhere", "recall, %", "precision, %",
       "and a scan: right within 5 m", "wrong anywhere", "recall, %", "precision, %"},
      rows);
}

}  // namespace

void measure_recognition_loops(const RecognitionSettings& settings, Report& report) {
  struct Way {
    std::string name;
    StreetCourse course;
  };
  const double most_m = 100.0 * settings.cases_or(kHundreds);
  std::vector<Way> ways;
  for (const char* const name : {"kitti00", "kitti05", "kitti07"})
    ways.push_back({name, read_course(settings.data + "/loop_poses/" + name + ".txt", kStep_m, most_m)});
  if (ways[0].course.poses.empty())
    return report.skip("long drives", "loop_poses is not in " + settings.data);
  ways.push_back({"kitti07, out and back", there_and_back(ways[2].course, 400.0, 2.0)});
  Json drives = Json::array(), rows = Json::array();
  LoopTallies all;
  for (const Way& way : ways) {
    testing::Draws draws(settings.seed);
    const StreetTown town(way.course, draws);
    const LoopDrive drive = drive_loops(way.course, town, kLidar, {}, draws);
    LoopTallies tallies;
    tallies.add(drive, way.course.way_m());
    all.add(drive, way.course.way_m());
    add_rows(way.name, tallies, rows);
    Rounds speaking;
    int by[static_cast<int>(SetVerdict::undecided) + 1]{};
    for (const LoopLook& look : drive.looks) {
      speaking.add(look.speaking);
      ++by[static_cast<int>(look.verdict)];
    }
    const auto of = [&by](SetVerdict verdict) { return by[static_cast<int>(verdict)]; };
    drives.push_back({way.name, std::round(way.course.way_m()), town.things(), drive.targets, drive.evicted,
                      std::round(10 * drive.drifted_m) / 10, std::round(10 * drive.drifted_deg) / 10,
                      median(speaking), drive.looks.size(), of(SetVerdict::found), of(SetVerdict::few),
                      of(SetVerdict::inconsistent), of(SetVerdict::ambiguous),
                      of(SetVerdict::bent) + of(SetVerdict::narrow), of(SetVerdict::undecided)});
  }
  add_rows("all", all, rows);
  Figure figure;
  figure.group = "loops";
  figure.what = "looks in which a scan and segments find a wrong place, a km";
  figure.n = static_cast<std::uint64_t>(all.by[1].all.looks);
  figure.ours = spread(all.by[1].per_km(all.by[1].all.wrong));
  set_goal(figure, "none", all.by[1].all.wrong == 0);
  report.add(figure);
  report.add_table("loops",
                   {"drive", "way, m", "believed", "revisits", "recognised", "within 3 m",
                    "way until then, m", "looks on them", "of these right, %", "right, all", "wrong, all",
                    "precision, %", "right a km", "wrong a km", "off, m", "deg"},
                   rows);
  report.add_table("loops",
                   {"drive", "way, m", "things", "targets", "given up", "odometry off at the end, m", "deg",
                    "segments that speak", "looks", "found", "few", "inconsistent", "ambiguous",
                    "bent, narrow", "undecided"},
                   drives);
  add_by_distance(all, report);
  add_by_set(all, report);
  report.note("loops",
              "Ways: key frames of real drives, from above. Made up, seed " + std::to_string(settings.seed) +
                  ": the towns, the lidar (64 rows of 256, 2 cm) and the odometry (1 % of way, 0.1 degrees a "
                  "root of a metre). A metre and a look a second. A revisit: 10 m or more within 5 m of a "
                  "place that was left more than 100 m of way before. Wrong: more than 1 m or 5 degrees off, "
                  "or nothing kept within 25 m. Errors are RMS of the right ones.");
}

}  // namespace sortie::bench
