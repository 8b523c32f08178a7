// SPDX-License-Identifier: BSD-3-Clause
// Sequences as text: one operation a line, numbers in hexadecimal so that they come back to the last bit.
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

namespace {

std::string exact_text(double value) {
  char text[40];
  if (std::isnan(value)) {  // with its sign and load
    std::snprintf(text, sizeof text, "nan:%016llx",
                  static_cast<unsigned long long>(std::bit_cast<std::uint64_t>(value)));
  } else {
    std::snprintf(text, sizeof text, "%a", value);
  }
  return text;
}

bool exact_value(const std::string& text, double& value) {
  char* end = nullptr;
  if (text.rfind("nan:", 0) == 0) {
    value = std::bit_cast<double>(static_cast<std::uint64_t>(std::strtoull(text.c_str() + 4, &end, 16)));
    return *end == '\0' && std::isnan(value);
  }
  value = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0';
}

}  // namespace

std::string sequence_text(const std::string& module, std::span<const CampaignOp> ops) {
  std::string text = "module " + module + "\n# op: kind, step in ns, values\n";
  for (const CampaignOp& op : ops) {
    text += "op " + std::to_string(op.kind) + " " + std::to_string(op.step_ns);
    for (const double value : op.value) text += " " + exact_text(value);
    text += "\n";
  }
  return text;
}

std::vector<CampaignOp> read_sequence(const std::string& text, std::string& module) {
  std::vector<CampaignOp> ops;
  module.clear();
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word[0] == '#') continue;
    const auto refuse = [&] { throw std::invalid_argument("line " + std::to_string(number) + ": " + line); };
    if (word == "module") {
      if (!(words >> module)) refuse();
    } else if (word == "op") {
      CampaignOp op;
      if (!(words >> op.kind >> op.step_ns)) refuse();
      for (double& value : op.value) {
        if (!(words >> word) || !exact_value(word, value)) refuse();
      }
      ops.push_back(op);
    } else {
      refuse();
    }
    if (words >> word) refuse();
  }
  if (module.empty()) throw std::invalid_argument("no line 'module NAME'");
  return ops;
}

}  // namespace sortie::bench
