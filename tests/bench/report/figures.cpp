// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/report/figures.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::bench {

double Rounds::quantile(double share) const {
  if (values_.empty()) return std::nan("");
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(share * n - 1e-9)));
  return sorted[std::min(rank, sorted.size()) - 1];
}

double Rounds::median() const {
  // Of an even number of rounds the middle of the two in the middle.
  return values_.size() % 2 == 1
             ? quantile(0.5)
             : 0.5 * (quantile(0.5) + quantile(0.5 + 1.0 / static_cast<double>(values_.size())));
}
double Rounds::low() const { return quantile(0); }
double Rounds::high() const { return quantile(1); }

Rounds ratio(const Rounds& own, const Rounds& theirs) {
  Rounds result;
  for (std::size_t i = 0; i < std::min(own.size(), theirs.size()); ++i) {
    if (theirs.values()[i] > 0) result.add(own.values()[i] / theirs.values()[i]);
  }
  return result;
}

Json spread(const Rounds& rounds) {
  return {{"value", rounds.median()}, {"low", rounds.low()}, {"high", rounds.high()}};
}

Json spread(double value) { return {{"value", value}}; }

void set_goal(Figure& figure, const std::string& words, bool met) {
  figure.goal = words;
  figure.met = met;
}

void Report::add(const Figure& figure) {
  Json line{{"group", figure.group},
            {"what", figure.what},
            {"unit", figure.unit},
            {"n", figure.n},
            {"ours", figure.ours}};
  if (!figure.peer.empty()) {
    line["peer"] = figure.peer;
    line["theirs"] = figure.theirs;
    line["ratio"] = figure.ratio;
  }
  if (!figure.goal.empty()) {
    line["goal"] = figure.goal;
    line["met"] = figure.met;
  }
  root_["figures"].push_back(line);
}

void Report::skip(const std::string& what, const std::string& why) {
  root_["skipped"].push_back({{"what", what}, {"why", why}});
}

void Report::note(const std::string& group, const std::string& words) {
  root_["notes"].push_back({{"group", group}, {"words", words}});
}

void Report::add_table(const std::string& group, const std::vector<std::string>& columns, const Json& rows) {
  root_["tables"].push_back({{"group", group}, {"columns", columns}, {"rows", rows}});
}

void Report::add_distribution(const std::string& name, const rt::LatencyHistogram& histogram) {
  Json bins = Json::array();
  histogram.for_each_bucket([&bins](std::uint64_t low, std::uint64_t high, std::uint64_t count) {
    bins.push_back({static_cast<double>(low) * 1e-3, static_cast<double>(high + 1) * 1e-3, count});
  });
  root_["distributions"].push_back({{"name", name},
                                    {"n", histogram.count()},
                                    {"max_us", static_cast<double>(histogram.max()) * 1e-3},
                                    {"bins_us", bins}});
}

void Report::add_distribution(const std::string& name, const std::vector<std::uint64_t>& bins_us,
                              std::uint64_t max_us) {
  Json bins = Json::array();
  std::uint64_t n = 0;
  for (std::size_t us = 0; us < bins_us.size(); ++us) {
    n += bins_us[us];
    if (bins_us[us] != 0) bins.push_back({us, us + 1, bins_us[us]});
  }
  root_["distributions"].push_back({{"name", name}, {"n", n}, {"max_us", max_us}, {"bins_us", bins}});
}

}  // namespace sortie::bench
