// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/commands/gate.hpp"

#include <toml++/toml.h>
#include <cmath>
#include <map>
#include <sstream>

#include "firmware_like/profile.hpp"

namespace sortie::firmware {

namespace {

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
  figures["speed"] = results.speed;
  figures["ticks"] = static_cast<double>(results.ticks);
  return figures;
}

void check_table(const toml::table& table, const std::string& prefix, bool is_max, const std::string& path,
                 const std::map<std::string, double>& figures, std::vector<std::string>& broken) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    if (const toml::table* inner = node.as_table()) {
      check_table(*inner, name + ".", is_max, path, figures, broken);
      continue;
    }
    const std::string place = path + ":" + std::to_string(node.source().begin.line) + ": ";
    const auto bound = node.value<double>();
    const auto figure = figures.find(name);
    if (!bound || !node.is_number()) throw ProfileError(place + name + " must be a number");
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

}  // namespace

std::vector<std::string> check_gate(const std::string& path, const Results& results) {
  toml::table gate;
  try {
    gate = toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    throw ProfileError(path + ":" + std::to_string(error.source().begin.line) + ": " +
                       std::string(error.description()) + "; a gate file has tables [max] and [min]");
  }
  const auto figures = figures_of(results);
  std::vector<std::string> broken;
  for (const auto& [key, node] : gate) {
    const std::string name(key.str());
    const toml::table* table = node.as_table();
    if (table == nullptr || (name != "max" && name != "min")) {
      throw ProfileError(path + ":" + std::to_string(node.source().begin.line) + ": unknown key " + name +
                         "; a gate file has tables [max] and [min]");
    }
    check_table(*table, "", name == "max", path, figures, broken);
  }
  return broken;
}

}  // namespace sortie::firmware
