// SPDX-License-Identifier: BSD-3-Clause
// How well segments of different visits are told apart by what they look like, beside the published features.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/bench/recognition/descriptor_parts.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/recognition/roc_figures.hpp"
#include "tests/bench/recognition/segment_retrieval.hpp"

namespace sortie::bench {
namespace {

constexpr int kHalls = 16;
constexpr std::size_t kTargets = 1204;
constexpr double kGoal = 1.2;
constexpr double kMost_ms = 2.0;

/// What one policy gave, method by method.
struct JudgedHalls {
  const std::vector<HallPairs>* halls;
  SegmentLikeness likeness;
  std::vector<RocCurve> roc;                    ///< in the order of kLikenesses
  std::vector<std::vector<double>> drawn_area;  ///< by method and draw

  JudgedHalls(const std::vector<HallPairs>& visited, std::uint64_t seed)
      : halls(&visited), likeness(all_segments(visited)) {
    const DrawnHalls draws(visited.size(), seed);
    for (const Likeness by : kLikenesses) {
      roc.emplace_back(judged(by));
      drawn_area.push_back(draws.areas(roc.back()));
    }
  }

  static std::vector<const SpokenSegment*> all_segments(const std::vector<HallPairs>& visited) {
    std::vector<const SpokenSegment*> all;
    for (const HallPairs& hall : visited) {
      for (const HallVisit& visit : hall.visit) {
        for (const SpokenSegment& segment : visit.segments) all.push_back(&segment);
      }
    }
    return all;
  }

  std::vector<JudgedPair> judged(Likeness by) const {
    std::vector<JudgedPair> pairs;
    for_pairs(*halls, [&](const SpokenSegment& a, const SpokenSegment& b, SegmentTruth truth, std::size_t h) {
      pairs.push_back({likeness.distance(by, a, b), truth == SegmentTruth::same, h});
    });
    return pairs;
  }
};

/// In kLikenesses.
constexpr std::size_t kOurs = 0, kFeatures = 3;
static_assert(kLikenesses[kOurs] == Likeness::gated && kLikenesses[kFeatures] == Likeness::features);

/// How many of the same segments a store would take for the same ones by their looks.
void add_same_steps(const JudgedHalls& judged, const std::string& policy, Report& report) {
  const auto most = mapping::TargetStoreConfig{}.same_steps;
  double same = 0.0, alike = 0.0;
  for (const JudgedPair& pair : judged.judged(Likeness::steps)) {
    if (!pair.same) continue;
    same += 1.0;
    alike += pair.distance <= most ? 1.0 : 0.0;
  }
  report.note("descriptors", policy + ": " +
                                 std::to_string(std::lround(100.0 * alike / std::max(same, 1.0))) +
                                 " % of the same segments of two visits differ by at most " +
                                 std::to_string(most) + " steps, the same_steps of a store.");
}

void add_areas(const JudgedHalls& judged, const std::string& policy, Json& rows, Report& report) {
  for (std::size_t m = 0; m < judged.roc.size(); ++m) {
    const RocCurve& roc = judged.roc[m];
    const Json area = drawn_range(roc.area(), judged.drawn_area[m]);
    const ListRanks ranks = ranks_by(*judged.halls, judged.likeness, kLikenesses[m]);
    rows.push_back({policy, name_of(kLikenesses[m]), area["value"], area["low"], area["high"],
                    percent(roc.found_at(0.01)), percent(roc.found_at(0.1)), ranks.rank.size(), ranks.targets,
                    percent(ranks.within(1)), percent(ranks.within(5)), percent(ranks.within(16))});
  }
  const double ours = judged.roc[kOurs].area(), theirs = judged.roc[kFeatures].area();
  std::vector<double> ratios, missing, missing_ours, missing_theirs;
  for (int i = 0; i < DrawnHalls::kDraws; ++i) {
    const double a = judged.drawn_area[kOurs][static_cast<std::size_t>(i)];
    const double b = judged.drawn_area[kFeatures][static_cast<std::size_t>(i)];
    ratios.push_back(a / b);
    missing_ours.push_back(1.0 - a);
    missing_theirs.push_back(1.0 - b);
    missing.push_back((1.0 - a) / (1.0 - b));
  }
  Figure figure;
  figure.group = "descriptors";
  figure.what = policy + ": area under the ROC curve";
  figure.n = static_cast<std::uint64_t>(judged.judged(Likeness::gated).size());
  figure.ours = drawn_range(ours, judged.drawn_area[kOurs]);
  figure.peer = "seven eigenvalue features";
  figure.theirs = drawn_range(theirs, judged.drawn_area[kFeatures]);
  figure.ratio = drawn_range(ours / theirs, ratios);
  set_goal(figure, "1.2 times at least", ours >= kGoal * theirs);
  report.add(figure);
  if (kGoal * theirs > 1.0) {
    report.note("descriptors", policy +
                                   ": 1.2 times the area of the seven features would be more than 1, "
                                   "which is all there is.");
  }
  figure.what = policy + ": what the area lacks of 1";
  figure.ours = drawn_range(1.0 - ours, missing_ours);
  figure.theirs = drawn_range(1.0 - theirs, missing_theirs);
  figure.ratio = drawn_range((1.0 - ours) / (1.0 - theirs), missing);
  figure.goal.clear();
  figure.met = nullptr;
  report.add(figure);
}

void add_curves(const JudgedHalls& judged, HallPolicy policy, Report& report) {
  Picture picture{
      std::string("bench-recognition-roc-") + (policy == HallPolicy::smoothness ? "smooth" : "near"),
      "descriptors",
      std::string("Segments of two visits, by ") + name_of(policy),
      "different segments accepted",
      "same segments found",
      false,
      false,
      false,
      {}};
  for (std::size_t m = 0; m < judged.roc.size(); ++m) {
    picture.curves.push_back(
        roc_line(judged.roc[m], name_of(kLikenesses[m]), m == 1 || m == 4 ? "dashed" : ""));
  }
  add_picture(report, picture);
}

/// By how the second way lies to the first one.
void add_ways(const JudgedHalls& judged, const std::string& policy, Json& rows) {
  for (const SecondWay way : {SecondWay::along, SecondWay::against, SecondWay::across}) {
    std::vector<double> times;
    std::size_t count = 0, same = 0, different = 0, between = 0;
    std::uint64_t silenced = 0;
    for (const HallPairs& hall : *judged.halls) {
      times.push_back(hall.way == way ? 1.0 : 0.0);
      if (hall.way != way) continue;
      ++count;
      for (const SegmentTruth truth : hall.truth) {
        ++(truth == SegmentTruth::same ? same : truth == SegmentTruth::between ? between : different);
      }
      for (const HallVisit& visit : hall.visit) silenced += visit.silenced;
    }
    rows.push_back({policy, name_of(way), count, same, different, between, silenced,
                    thousandths(judged.roc[kOurs].area(times)),
                    thousandths(judged.roc[kFeatures].area(times))});
  }
}

void add_times(const std::vector<HallPairs>& halls, const std::string& policy, Report& report) {
  const RetrievalTimes times = time_retrieval(halls, kTargets, 51);
  Rounds describe;
  for (const HallPairs& hall : halls) {
    for (const HallVisit& visit : hall.visit) {
      for (const double ms : visit.described_ms.values()) describe.add(ms);
    }
  }
  Figure figure;
  figure.group = "descriptors";
  figure.what = policy + ": 16 candidates of 1,204 targets, 64 segments";
  figure.unit = "ms";
  figure.n = times.ours_ms.size();
  figure.ours = spread(times.ours_ms);
  figure.peer = "seven features, all targets";
  figure.theirs = spread(times.features_ms);
  figure.ratio = spread(ratio(times.ours_ms, times.features_ms));
  report.add(figure);
  Figure both;
  both.group = "descriptors";
  both.what = policy + ": a round's description, and candidates of 64 segments";
  both.unit = "ms";
  both.n = describe.size();
  const double retrieval = times.ours_ms.median();
  both.ours = {{"value", describe.median() + retrieval},
               {"low", describe.low() + retrieval},
               {"high", describe.high() + retrieval}};
  set_goal(both, "2 ms, median", describe.median() + retrieval <= kMost_ms);
  report.add(both);
  report.note(
      "descriptors",
      policy + ": the gate of sizes lets " + std::to_string(std::lround(100 * times.compared)) +
          " % of the targets through; searches of 64 that found another list than a look at all targets: " +
          std::to_string(times.wrong) + ".");
}

}  // namespace

void measure_recognition_descriptors(const RecognitionSettings& settings, Report& report) {
  const VisitedHalls visited = visit_halls(settings.cases_or(kHalls), settings.seed);
  Json areas = Json::array(), ways = Json::array(), parts = Json::array();
  for (const HallPolicy policy : {HallPolicy::smoothness, HallPolicy::euclidean}) {
    const std::vector<HallPairs>& halls = visited.by[static_cast<int>(policy)];
    const std::string name = name_of(policy);
    const JudgedHalls judged(halls, settings.seed);
    add_areas(judged, name, areas, report);
    add_same_steps(judged, name, report);
    add_curves(judged, policy, report);
    add_ways(judged, name, ways);
    for (const Json& row : part_rows(halls, name)) parts.push_back(row);
    add_times(halls, name, report);
  }
  report.add_table("descriptors",
                   {"segments", "by", "area", "5 %", "95 %", "found at 1 % false", "at 10 %",
                    "segments asked", "targets", "first, %", "in 5", "in 16"},
                   areas);
  report.add_table("descriptors",
                   {"segments", "second visit", "halls", "same", "different", "between", "silenced",
                    "area, ours", "area, seven features"},
                   ways);
  report.add_table("descriptors", kPartColumns, parts);
  report.note(
      "descriptors",
      "Made-up halls, each visited twice by another way, with another lidar, in a map that is turned "
      "anyhow; poses are true. Same: of either segment half of the voxels or more lie within 0.2 m of "
      "the other one; different: of either less than a tenth; what is between is left out. Areas: "
      "pairs of one hall; their range: nine of ten sets of halls that are drawn anew. Lists: a store "
      "of the first visits of all halls. Pillars of a hall are all alike, and count as different.");
}

}  // namespace sortie::bench
