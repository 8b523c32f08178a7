// SPDX-License-Identifier: BSD-3-Clause
// A benchmark of several parts: those that are asked for, as one JSON object.
#pragma once

#include <iostream>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// A part, and the name it is asked for by.
template <class Settings>
struct BenchPart {
  const char* name;
  void (*measure)(const Settings&, Report&);
};

/// Measures the part named `only`, or all where it is empty, and prints one JSON object, in which `said` are
/// the settings. Throws std::invalid_argument with the parts there are.
template <class Settings>
void print_parts(std::span<const BenchPart<Settings>> parts, const Settings& settings,
                 const std::string& only, Json said) {
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  for (const char* list : {"figures", "tables", "skipped", "notes", "pictures"}) root[list] = Json::array();
  said["only"] = only;
  root["settings"] = std::move(said);
  bool found = false;
  std::string names;
  for (const BenchPart<Settings>& part : parts) {
    names += std::string(names.empty() ? "" : ", ") + part.name;
    if (!only.empty() && only != part.name) continue;
    found = true;
    std::cerr << "measuring: " << part.name << std::endl;
    part.measure(settings, report);
  }
  if (!found) throw std::invalid_argument("--only takes one of " + names);
  root["load_after"] = load_average();
  std::cout << root.dump() << std::endl;
}

}  // namespace sortie::bench
