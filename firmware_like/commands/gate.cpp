// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/commands/gate.hpp"

#include <cmath>
#include <map>
#include <sstream>

#include "firmware_like/profile.hpp"
#include "firmware_like/toml_file.hpp"

namespace sortie::firmware {

namespace {

// The larger of both; what is no number stays, and breaks every bound.
double larger(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

// What holds for all tasks, groups and pools together, so that a gate need not name each of them.
void add_whole(const Results& results, std::map<std::string, double>& figures) {
  double missed = 0;
  double refused = 0;
  double longest = 0;
  double latest = 0;
  for (const TaskResult& task : results.tasks) longest = larger(longest, task.max_us);
  for (const GroupResult& group : results.groups) {
    missed += static_cast<double>(group.missed);
    latest = larger(latest, group.response_max_us);
  }
  for (const PoolResult& pool : results.pools) refused += static_cast<double>(pool.refused);
  figures["all.missed"] = missed;
  figures["all.refused"] = refused;
  figures["all.max_us"] = longest;
  figures["all.response_max_us"] = latest;
}

void add_measured(const std::string& prefix, const ChainFigures& measured,
                  std::map<std::string, double>& figures) {
  if (measured.count == 0) return;  // nothing was measured: a bound on it is an error, not kept
  figures[prefix + ".p50_us"] = measured.p50_us;
  figures[prefix + ".p99_us"] = measured.p99_us;
  figures[prefix + ".max_us"] = measured.max_us;
}

std::map<std::string, double> figures_of(const Results& results) {
  std::map<std::string, double> figures;
  for (const auto& [name, value] : results.errors) figures["errors." + name] = value;
  for (const auto& [name, value] : results.counters) figures["counters." + name] = static_cast<double>(value);
  for (const TaskResult& task : results.tasks) {
    const std::string prefix = "tasks." + task.name + ".";
    figures[prefix + "count"] = static_cast<double>(task.count);
    figures[prefix + "missed"] = static_cast<double>(task.missed);
    figures[prefix + "p50_us"] = task.p50_us;
    figures[prefix + "p99_us"] = task.p99_us;
    figures[prefix + "p999_us"] = task.p999_us;
    figures[prefix + "max_us"] = task.max_us;
  }
  for (const PoolResult& pool : results.pools) {
    const std::string prefix = "pools." + pool.name + ".";
    figures[prefix + "high_water"] = static_cast<double>(pool.high_water);
    figures[prefix + "refused"] = static_cast<double>(pool.refused);
  }
  for (const GroupResult& group : results.groups) {
    const std::string prefix = "groups." + group.name + ".";
    figures[prefix + "missed"] = static_cast<double>(group.missed);
    figures[prefix + "skipped"] = static_cast<double>(group.skipped);
    figures[prefix + "worst_in_row"] = static_cast<double>(group.worst_in_row);
    figures[prefix + "late_max_us"] = group.late_max_us;
    figures[prefix + "response_max_us"] = group.response_max_us;
  }
  for (const ChainResult& chain : results.chains) {
    const std::string prefix = "chains." + chain.name + ".";
    figures[prefix + "reaction_us"] = chain.reaction_us;
    figures[prefix + "age_us"] = chain.age_us;
    add_measured(prefix + "measured_reaction", chain.reaction, figures);
    add_measured(prefix + "measured_age", chain.age, figures);
    add_measured(prefix + "measured_finished", chain.finished, figures);
  }
  add_whole(results, figures);
  figures["speed"] = results.speed;
  figures["ticks"] = static_cast<double>(results.ticks);
  return figures;
}

void check_table(const TomlNode& table, const std::string& prefix, bool is_max, const std::string& path,
                 const std::map<std::string, double>& figures, std::vector<std::string>& broken) {
  for (const auto& [key, node] : table.entries()) {
    const std::string name = prefix + key;
    if (node.is_table()) {
      check_table(node, name + ".", is_max, path, figures, broken);
      continue;
    }
    const std::string place = path + ":" + std::to_string(node.line()) + ": ";
    const auto bound = node.number();
    const auto figure = figures.find(name);
    if (!bound) throw ProfileError(place + name + " must be a number");
    if (figure == figures.end()) {
      throw ProfileError(place + "the result has no figure " + name +
                         "; `sortie replay LOG --json` shows what it has");
    }
    // Written so that a figure that is not a number breaks every bound.
    const bool kept = is_max ? figure->second <= *bound : figure->second >= *bound;
    if (kept) continue;
    std::ostringstream line;
    line << place << name << " = " << figure->second << (is_max ? ", at most " : ", at least ") << *bound;
    broken.push_back(line.str());
  }
}

// [equal]: what must be as it was, text for text.
void check_equal(const TomlNode& table, const std::string& path, const Results& results,
                 std::vector<std::string>& broken) {
  const std::map<std::string, std::string> words{
      {"digest", results.digest}, {"scene", results.scene}, {"vehicle", results.vehicle}};
  for (const auto& [name, node] : table.entries()) {
    const std::string place = path + ":" + std::to_string(node.line()) + ": ";
    const auto wanted = node.text();
    const auto word = words.find(name);
    if (word == words.end()) throw ProfileError(place + name + ": [equal] takes digest, scene and vehicle");
    if (!wanted) throw ProfileError(place + name + " must be a text");
    if (*wanted != word->second)
      broken.push_back(place + name + " = " + word->second + ", wanted " + *wanted);
  }
}

constexpr const char* kGateTables = "a gate file has tables [max], [min] and [equal]";

}  // namespace

std::vector<std::string> check_gate(const std::string& path, const Results& results) {
  TomlTree gate;
  try {
    gate = TomlTree::read(path);
  } catch (const TomlError& error) {
    throw ProfileError(path + ":" + std::to_string(error.line()) + ": " + error.what() + "; " + kGateTables);
  }
  const auto figures = figures_of(results);
  std::vector<std::string> broken;
  for (const auto& [name, node] : gate.root().entries()) {
    if (!node.is_table() || (name != "max" && name != "min" && name != "equal")) {
      throw ProfileError(path + ":" + std::to_string(node.line()) + ": unknown key " + name + "; " +
                         kGateTables);
    }
    if (name == "equal") {
      check_equal(node, path, results, broken);
      continue;
    }
    check_table(node, "", name == "max", path, figures, broken);
  }
  return broken;
}

}  // namespace sortie::firmware
