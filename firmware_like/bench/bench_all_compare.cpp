// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>
#include <map>

#include "firmware_like/bench/bench_all.hpp"
#include "firmware_like/bench/figure_passes.hpp"
#include "firmware_like/importers/input_error.hpp"
#include "firmware_like/json.hpp"

namespace sortie::firmware {

namespace {

using ComparedFigures = std::map<std::string, Json>;

Json read_object(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return Json::parse_or_null(in);
}

// The benchmark of the real-time ground has nothing but times.
bool is_timed(const std::string& part, const Json& figure) { return part == "rt" || is_timed_figure(figure); }

// The place of a figure; twins are counted.
void take_figure(ComparedFigures& figures, std::string name, const Json& figure) {
  std::string place = name;
  for (int twin = 2; figures.count(place) != 0; ++twin) place = name + " #" + std::to_string(twin);
  figures.emplace(std::move(place), figure);
}

ComparedFigures figures_of(const std::string& part, const Json& result) {
  ComparedFigures figures;
  for (const Json& figure : result.value("figures", Json::array())) {
    take_figure(figures, part + ", " + figure_name(figure), figure);
  }
  // The odometry's benchmark has cells instead: an error each.
  for (const Json& cell : result.value("cells", Json::array())) {
    std::string name = part;
    for (const auto& [key, value] : cell.items()) {
      if (value.is_string()) name += ", " + value.get<std::string>();
      if (key == "rate_hz") name += ", " + value.dump() + " Hz";
    }
    const Json errors = cell.value("errors", Json::object());
    for (const auto& [key, value] : errors.items())
      take_figure(figures, name + ": " + key, {{"ours", {{"value", value}}}, {"unit", key}});
  }
  return figures;
}

bool has_range(const Json& ratio) {
  return ratio.is_object() && ratio.contains("low") && ratio["low"].is_number() && ratio.contains("high") &&
         ratio["high"].is_number();
}

bool meet(const Json& a, const Json& b) {
  return a["low"].get<double>() <= b["high"].get<double>() &&
         b["low"].get<double>() <= a["high"].get<double>();
}

void compare_figure(const std::string& part, const std::string& name, const Json& before, const Json& now,
                    BenchComparison& result) {
  if (!is_timed(part, before)) {
    ++result.exact;
    const Json was = exact_figure(before);
    const Json is = exact_figure(now);
    if (was != is) result.changed.push_back(name + ": was " + was.dump() + ", is " + is.dump());
    return;
  }
  const Json was = before.value("ratio", Json());
  const Json is = now.value("ratio", Json());
  if (!has_range(was) || !has_range(is)) {
    ++result.unjudged;
    return;
  }
  ++result.ratios;
  if (!meet(was, is)) result.outside.push_back(name + ": ratio was " + was.dump() + ", is " + is.dump());
}

}  // namespace

BenchComparison compare_bench(const std::string& before, const std::string& now) {
  for (const std::string& folder : {before, now}) {
    if (!read_object(folder + "/index.json").is_object())
      throw InputError(folder + "/index.json: is not there or damaged; give a folder of `bench all --out`");
  }
  BenchComparison result;
  for (const BenchPart& part : bench_parts()) {
    const std::string file = "/" + part.name + "/" + part.json_file;
    const Json was = read_object(before + file);
    const Json is = read_object(now + file);
    if (!was.is_object() && !is.is_object()) continue;
    if (!was.is_object() || !is.is_object()) {
      result.missing.push_back(part.name + " is only in " + (was.is_object() ? before : now));
      continue;
    }
    const ComparedFigures old_figures = figures_of(part.name, was);
    const ComparedFigures new_figures = figures_of(part.name, is);
    for (const auto& [name, figure] : old_figures) {
      const auto found = new_figures.find(name);
      if (found == new_figures.end()) {
        ++result.unjudged;
        continue;
      }
      compare_figure(part.name, name, figure, found->second, result);
    }
    for (const auto& [name, unused] : new_figures) result.unjudged += old_figures.count(name) == 0 ? 1 : 0;
  }
  return result;
}

}  // namespace sortie::firmware
