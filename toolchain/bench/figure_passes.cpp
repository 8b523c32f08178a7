// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/figure_passes.hpp"

#include <algorithm>
#include <set>

#include "firmware_like/scene/json.hpp"

namespace sortie::toolchain {

namespace {

double bound(const firmware::Json& spread, const char* name) {
  const auto found = spread.find(name);
  return found != spread.end() && found->is_number() ? found->get<double>() : spread["value"].get<double>();
}

bool is_spread(const firmware::Json& object) {
  return object.is_object() && object.contains("value") && object["value"].is_number();
}

void widen(firmware::Json& spread, const firmware::Json& later, unsigned passes) {
  if (!is_spread(spread) || !is_spread(later)) return;
  const double low = std::min(bound(spread, "low"), bound(later, "low"));
  const double high = std::max(bound(spread, "high"), bound(later, "high"));
  const double mean =
      (spread["value"].get<double>() * passes + later["value"].get<double>()) / (passes + 1.0);
  spread = {{"value", mean}, {"low", low}, {"high", high}};
}

void take_figure_pass(firmware::Json& figure, const firmware::Json& later, unsigned passes) {
  for (const char* side : {"ours", "theirs", "ratio"})
    if (figure.contains(side) && later.contains(side)) widen(figure[side], later[side], passes);
  if (figure.contains("n") && figure["n"].is_number_unsigned() && later.contains("n"))
    figure["n"] = figure["n"].get<std::uint64_t>() + later["n"].get<std::uint64_t>();
  if (figure.contains("met") && figure["met"].is_boolean())
    figure["met"] = figure["met"].get<bool>() && later.value("met", firmware::Json(true)) == true;
}

// What must be the same at every run, if the figure is not timed.
firmware::Json exact_figure(const firmware::Json& figure) {
  firmware::Json exact = firmware::Json::object();
  for (const char* key : {"ours", "naive", "measured"})
    if (figure.contains(key)) exact[key] = figure[key];
  return exact;
}

std::string figure_name(const firmware::Json& figure) {
  const std::string peer = figure.value("peer", "");
  return figure.value("group", "") + ": " + figure.value("what", "") +
         (peer.empty() ? "" : ", beside " + peer);
}

}  // namespace

bool is_timed_figure(const firmware::Json& figure) {
  static const std::set<std::string> kTimes{"ns", "us", "ms", "times", "M/s", "us/s", "1/s"};
  const std::string unit = figure.value("unit", "");
  const firmware::Json ours = figure.value("ours", firmware::Json());
  const bool has_range = ours.is_object() && ours.contains("low");
  return kTimes.count(unit) != 0 || (unit.empty() && has_range);
}

std::string passes_words(const firmware::Json& result) {
  const unsigned passes = result.value("settings", firmware::Json::object()).value("passes", 1u);
  return passes > 1 ? ", " + std::to_string(passes) + " passes" : "";
}

void take_pass(firmware::Json& result, const firmware::Json& later, unsigned passes, bool all_timed) {
  firmware::Json unsteady = result.value("unsteady", firmware::Json::array());
  firmware::Json& figures = result["figures"];
  const firmware::Json others = later.value("figures", firmware::Json::array());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    // The same program reports in the same order, unless something was skipped in one of the runs.
    const bool is_same =
        others.is_array() && i < others.size() && figure_name(figures[i]) == figure_name(others[i]);
    const bool is_timed = all_timed || is_timed_figure(figures[i]);
    if (!is_same || (!is_timed && exact_figure(figures[i]) != exact_figure(others[i]))) {
      unsteady.push_back(figure_name(figures[i]));
    } else if (is_timed) {
      take_figure_pass(figures[i], others[i], passes);
    }
  }
  if (!unsteady.empty()) result["unsteady"] = std::move(unsteady);  // moves all others
}

}  // namespace sortie::toolchain
