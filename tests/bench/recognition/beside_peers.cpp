// SPDX-License-Identifier: BSD-3-Clause
// Consistent sets beside others: time, and what is chosen.
#include <cmath>
#include <string>

#include "tests/bench/recognition/owned_sets.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"

namespace sortie::bench {
namespace {

constexpr double kEps_m = 0.4;

/// Rounds of one method.
struct SetRounds {
  Rounds ms, precision, recall;

  void add(const SetScene& scene, const Chosen& chosen, double took_ms) {
    const ChosenShares shares = shares_of(scene, chosen);
    ms.add(took_ms);
    precision.add(100.0 * shares.precision);
    recall.add(100.0 * shares.recall);
  }
};

double mean(const Rounds& rounds) {
  double sum = 0.0;
  for (const double v : rounds.values()) sum += v;
  return rounds.empty() ? 0.0 : sum / static_cast<double>(rounds.size());
}

double cut(double value, double steps) { return std::round(steps * value) / steps; }

Json row(const std::string& scene, const std::string& who, const SetRounds& r) {
  return {scene,
          who,
          r.ms.size(),
          cut(r.ms.median(), 100),
          cut(r.ms.quantile(0.99), 100),
          cut(r.ms.high(), 100),
          cut(mean(r.precision), 10),
          cut(r.precision.low(), 10),
          cut(mean(r.recall), 10),
          cut(r.recall.low(), 10)};
}

const std::vector<std::string> kColumns{
    "scene", "method", "n", "ms", "p99", "max", "right of chosen, %", "worst", "chosen of right, %",
    "worst "};

Figure figure_of(const std::string& group, const std::string& what, const SetRounds& ours, const char* peer,
                 const SetRounds& theirs, double share) {
  Figure figure;
  figure.group = group;
  figure.what = what;
  figure.unit = "ms";
  figure.n = ours.ms.size();
  figure.ours = spread(ours.ms);
  figure.peer = peer;
  figure.theirs = spread(theirs.ms);
  const Rounds of = ratio(ours.ms, theirs.ms);
  figure.ratio = spread(of);
  if (share > 0.0) {
    const bool as_good =
        mean(ours.precision) >= mean(theirs.precision) && mean(ours.recall) >= mean(theirs.recall);
    set_goal(figure, "1/" + std::to_string(static_cast<int>(1.0 / share + 0.5)) + " at most, no less right",
             of.median() <= share && as_good);
  }
  return figure;
}
}  // namespace

void measure_recognition_streets(const RecognitionSettings& settings, Report& report) {
  const int cases = settings.cases_or(100);
  OwnedSets owned(53 * 58);
  mapping::SetConfig config, published;
  published.gravity = false;
  SetRounds ours, flat, pcl;
  Json rows = Json::array();
  for (int i = 0; i < cases; ++i) {
    const SetScene scene = street_scene(settings.seed + static_cast<std::uint64_t>(i));
    Chosen chosen;
    const double ms = owned.search(config, scene, ~std::uint64_t{0}, chosen);
    ours.add(scene, chosen, ms);
    const double flat_ms = owned.search(published, scene, ~std::uint64_t{0}, chosen);
    flat.add(scene, chosen, flat_ms);
    double pcl_ms = 0.0;
    if (pcl_grouping(scene.pairs, kEps_m, static_cast<int>(config.least), chosen, pcl_ms))
      pcl.add(scene, chosen, pcl_ms);
  }
  const std::string name = "3,074 correspondences, 1,204 targets";
  rows.push_back(row(name, "ours", ours));
  rows.push_back(row(name, "ours, distances in space", flat));
  Figure figure;
  if (pcl.ms.empty()) {
    report.skip("PCL's grouping", "PCL is not there; cure: apt-get install libpcl-dev");
    figure.group = "streets";
    figure.what = "whole search";
    figure.unit = "ms";
    figure.n = ours.ms.size();
    figure.ours = spread(ours.ms);
  } else {
    rows.push_back(row(name, "PCL", pcl));
    figure = figure_of("streets", "whole search", ours, "PCL's GeometricConsistencyGrouping", pcl, 1.0 / 40);
  }
  report.add(figure);
  report.add_table("streets", kColumns, rows);
}

void measure_recognition_outliers(const RecognitionSettings& settings, Report& report) {
  const int cases = settings.cases_or(40);
  OwnedSets owned(1000);
  mapping::SetConfig config, published;
  published.gravity = false;
  Json rows = Json::array();
  for (const double wrong : {0.9, 0.95, 0.99}) {
    SetRounds ours, flat, dense, core;
    for (int i = 0; i < cases; ++i) {
      const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
      const SetScene scene = outlier_scene(1000, wrong, seed);
      Chosen chosen;
      const double ms = owned.search(config, scene, ~std::uint64_t{0}, chosen);
      ours.add(scene, chosen, ms);
      const double flat_ms = owned.search(published, scene, ~std::uint64_t{0}, chosen);
      flat.add(scene, chosen, flat_ms);
      double begin = set_cpu_ms();
      chosen = dense_cluster(scene.pairs, kEps_m, seed);
      dense.add(scene, chosen, set_cpu_ms() - begin);
      begin = set_cpu_ms();
      chosen = densest_core(scene.pairs, kEps_m);
      core.add(scene, chosen, set_cpu_ms() - begin);
    }
    const std::string name = std::to_string(static_cast<int>(100 * wrong + 0.5)) + " % of 1,000 wrong";
    rows.push_back(row(name, "ours", ours));
    rows.push_back(row(name, "ours, distances in space", flat));
    rows.push_back(row(name, "dense cluster (CLIPPER)", dense));
    rows.push_back(row(name, "densest core (ROBIN)", core));
    report.add(figure_of("outliers", name, ours, "a dense cluster (CLIPPER, re-made)", dense, 0.1));
  }
  report.add_table("outliers", kColumns, rows);
}

}  // namespace sortie::bench
