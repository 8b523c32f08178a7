// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/doctor_table.hpp"

#include <algorithm>
#include <ostream>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

constexpr std::size_t kIndent = 26;
constexpr std::size_t kWidth = 100;

// By Health: good, warn, bad, unknown.
constexpr const char* kColours[] = {"\033[32m", "\033[33m", "\033[31m", "\033[2m"};
constexpr int kRanks[] = {3, 1, 0, 2};

const char* colour_of(Health health) { return kColours[static_cast<std::size_t>(health)]; }
int rank(Health health) { return kRanks[static_cast<std::size_t>(health)]; }

/// Words from column kIndent on, broken before column kWidth; the first line has begun.
void print_wrapped(std::ostream& out, const std::string& text) {
  std::size_t column = kIndent;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (column > kIndent && column + 1 + end - begin > kWidth) {
      out << '\n' << std::string(kIndent, ' ');
      column = kIndent;
    } else if (column > kIndent) {
      out << ' ';
      ++column;
    }
    out << text.substr(begin, end - begin);
    column += end - begin;
    begin = end + 1;
  }
  out << '\n';
}

}  // namespace

void print_doctor(std::ostream& out, const DoctorReport& report, bool colour) {
  std::vector<const Finding*> order;
  for (const Finding& finding : report.findings) order.push_back(&finding);
  std::stable_sort(order.begin(), order.end(),
                   [](const Finding* a, const Finding* b) { return rank(a->verdict) < rank(b->verdict); });
  const std::string indent(kIndent, ' ');
  for (const Finding* finding : order) {
    const std::string word = pad_right(to_string(finding->verdict), 8);
    out << (colour ? colour_of(finding->verdict) + word + "\033[0m" : word);
    out << pad_right(finding->name, kIndent - 8 - 1) << ' ';
    print_wrapped(out, finding->value);
    if (finding->verdict == Health::good || finding->verdict == Health::unknown) continue;
    out << indent;
    print_wrapped(out, finding->why);
    // In one piece, so that it can be copied.
    if (!finding->cure.empty()) out << indent << "cure: " << finding->cure << '\n';
  }
  const std::string summary = report.summary();
  out << (colour ? colour_of(report.verdict()) + summary + "\033[0m" : summary) << '\n';
}

}  // namespace sortie::firmware
