// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/gate.hpp"

#include <sstream>

#include "firmware_like/scene/profile.hpp"

namespace sortie::toolchain {

namespace {

constexpr const char* kGateTables = "a gate file has tables [max], [min] and [equal]";

// Why a figure that a gate names is not there, and what to do.
std::string explain_absent(const std::string& name, const GateFigures& figures) {
  if (const auto why = figures.absent.find(name); why != figures.absent.end())
    return name + " " + why->second;
  return "the result has no figure " + name + "; --json of the same command shows what it has";
}

// [equal]: what must be as it was, text for text.
std::map<std::string, std::string> words_of(const firmware::Results& results) {
  return {{"digest", results.digest}, {"scene", results.scene}, {"vehicle", results.vehicle}};
}

}  // namespace

std::string Gate::place(const firmware::TomlNode& node) const {
  return path_ + ":" + std::to_string(node.line()) + ": ";
}

std::size_t Gate::check_kinds(const firmware::TomlNode& table, const std::string& prefix) const {
  std::size_t bounds = 0;
  for (const auto& [key, node] : table.entries()) {
    if (node.is_table()) {
      bounds += check_kinds(node, prefix + key + ".");
      continue;
    }
    if (!node.number()) throw firmware::ProfileError(place(node) + prefix + key + " must be a number");
    ++bounds;
  }
  return bounds;
}

Gate::Gate(std::string path) : path_(std::move(path)) {
  try {
    tree_ = firmware::TomlTree::read(path_);
  } catch (const firmware::TomlError& error) {
    throw firmware::ProfileError(path_ + ":" + std::to_string(error.line()) + ": " + error.what() + "; " +
                                 kGateTables);
  }
  std::size_t bounds = 0;
  const auto words = words_of({});
  for (const auto& [name, node] : tree_.root().entries()) {
    if (!node.is_table() || (name != "max" && name != "min" && name != "equal"))
      throw firmware::ProfileError(place(node) + "unknown key " + name + "; " + kGateTables);
    if (name != "equal") {
      bounds += check_kinds(node, "");
      continue;
    }
    for (const auto& [word, wanted] : node.entries()) {
      if (words.count(word) == 0)
        throw firmware::ProfileError(place(wanted) + word + ": [equal] takes digest, scene and vehicle");
      if (!wanted.text()) throw firmware::ProfileError(place(wanted) + word + " must be a text");
      ++bounds;
    }
  }
  if (bounds == 0)
    throw firmware::ProfileError(path_ + ": holds no bound, so it could not fail; " + kGateTables);
}

void Gate::hold(const firmware::TomlNode& table, const std::string& prefix, bool is_max,
                const GateFigures& figures, std::vector<std::string>& broken) const {
  for (const auto& [key, node] : table.entries()) {
    const std::string name = prefix + key;
    if (node.is_table()) {
      hold(node, name + ".", is_max, figures, broken);
      continue;
    }
    const double bound = *node.number();
    const auto figure = figures.known.find(name);
    if (figure == figures.known.end())
      throw firmware::ProfileError(place(node) + explain_absent(name, figures));
    // Written so that a figure that is not a number breaks every bound.
    const bool kept = is_max ? figure->second <= bound : figure->second >= bound;
    if (kept) continue;
    std::ostringstream line;
    line << place(node) << name << " = " << figure->second << (is_max ? ", at most " : ", at least ")
         << bound;
    broken.push_back(line.str());
  }
}

std::vector<std::string> Gate::judge(const firmware::Results& results) const {
  const GateFigures figures = gate_figures(results);
  const auto words = words_of(results);
  std::vector<std::string> broken;
  for (const auto& [name, node] : tree_.root().entries()) {
    if (name != "equal") {
      hold(node, "", name == "max", figures, broken);
      continue;
    }
    for (const auto& [word, wanted] : node.entries()) {
      const std::string& is = words.at(word);
      if (*wanted.text() != is)
        broken.push_back(place(wanted) + word + " = " + is + ", wanted " + *wanted.text());
    }
  }
  return broken;
}

}  // namespace sortie::toolchain
