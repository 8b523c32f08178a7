// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep.hpp"

#include <cstdlib>

#include "firmware_like/scene/profile.hpp"

namespace sortie::toolchain {

namespace {

std::string trim(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Commas outside of brackets and quotes divide. An unbalanced bracket is left for the TOML parser to name.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts{""};
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      parts.emplace_back();
      continue;
    }
    parts.back() += c;
  }
  for (std::string& part : parts) part = trim(part);
  return parts;
}

bool as_number(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

std::string without_quotes(const std::string& text) {
  const bool quoted =
      text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\'');
  return quoted ? text.substr(1, text.size() - 2) : text;
}

}  // namespace

SweepKnob parse_knob(const std::string& text) {
  const std::string cure = "; write key=v1,v2,v3, for example --sweep map.voxel_m=0.05,0.1,0.2";
  const std::string place = "--sweep " + text + ": ";
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw firmware::ProfileError(place + "no values" + cure);
  SweepKnob knob{trim(text.substr(0, equals)), split(text.substr(equals + 1))};
  if (knob.key.empty()) throw firmware::ProfileError(place + "no key" + cure);
  for (std::size_t i = 0; i < knob.values.size(); ++i) {
    if (knob.values[i].empty()) throw firmware::ProfileError(place + "an empty value" + cure);
    for (std::size_t j = 0; j < i; ++j) {
      if (same_value(knob.values[i], knob.values[j]))
        throw firmware::ProfileError(place + knob.values[i] + " stands there twice; give every value once");
    }
  }
  return knob;
}

std::vector<SweepKnob> parse_knobs(const std::vector<std::string>& texts, std::size_t most_cells) {
  std::vector<SweepKnob> knobs;
  std::size_t cells = 1;
  for (const std::string& text : texts) {
    SweepKnob knob = parse_knob(text);
    for (const SweepKnob& other : knobs) {
      if (other.key == knob.key)
        throw firmware::ProfileError("--sweep " + text + ": " + knob.key +
                                     " is swept already; give all its values in one --sweep");
    }
    if (knob.values.size() > most_cells / cells) {
      throw firmware::ProfileError("--sweep " + text + ": more than " + std::to_string(most_cells) +
                                   " cells in the grid; give fewer values");
    }
    cells *= knob.values.size();
    knobs.push_back(std::move(knob));
  }
  return knobs;
}

std::vector<std::vector<std::string>> span_grid(const std::vector<SweepKnob>& knobs) {
  std::vector<std::vector<std::string>> cells{{}};
  for (const SweepKnob& knob : knobs) {
    std::vector<std::vector<std::string>> next;
    for (const auto& cell : cells) {
      for (const std::string& value : knob.values) {
        next.push_back(cell);
        next.back().push_back(value);
      }
    }
    cells = std::move(next);
  }
  return cells;
}

bool same_value(const std::string& value, const std::string& other) {
  double a = 0;
  double b = 0;
  if (as_number(value, a) && as_number(other, b)) return a == b;
  return without_quotes(value) == without_quotes(other);
}

}  // namespace sortie::toolchain
