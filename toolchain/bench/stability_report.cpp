// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <ostream>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/figure_table.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

// A figure is a number, or a word for what is none.
std::string stability_figure(const firmware::Json& row, const char* key) {
  const auto found = row.find(key);
  if (found == row.end()) return "?";
  if (found->is_string()) return found->get<std::string>();
  if (!found->is_number()) return "?";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", found->get<double>());
  return text;
}

std::string stability_verdict(const firmware::Json& row) {
  if (!row.value("ours_within", false)) return "OUTSIDE";
  return row.value("naive_outside", false) ? "kept" : "NOT TOLD APART";
}

std::string stability_summary(const firmware::Json& result) {
  const firmware::Json counts = result.value("summary", firmware::Json::object());
  return std::to_string(counts.value("cases", 0)) + " cases: ours within the bound in " +
         std::to_string(counts.value("ours_within", 0)) + ", the naive method outside in " +
         std::to_string(counts.value("naive_outside", 0));
}

void print_stability(std::ostream& out, const firmware::Json& result, bool) {
  std::string group;
  for (const firmware::Json& row : result.value("figures", firmware::Json::array())) {
    if (row.value("group", "") != group) {
      group = row.value("group", "");
      out << "\n"
          << firmware::pad_right(group, 48) << firmware::pad_left("bound", 11)
          << firmware::pad_left("ours", 11) << firmware::pad_left("naive", 14) << "\n";
    }
    out << firmware::pad_right(firmware::shorten(row.value("what", ""), 47), 48)
        << firmware::pad_left(stability_figure(row, "bound"), 11)
        << firmware::pad_left(stability_figure(row, "ours"), 11)
        << firmware::pad_left(stability_figure(row, "naive"), 14) << "  " << stability_verdict(row) << "\n";
  }
  print_tables(out, result, "kernels");
  out << "\n" << stability_summary(result) << "\n";
}

std::string stability_page(const firmware::Json& result, const std::string& command) {
  std::string text = "# Stiff and extreme cases\n\nWritten by `" + command +
                     "`. Each case was run by the code of this repository and by the naive method; the bound "
                     "must lie between them. [What each case is](../stability.md).\n\n```\nmachine   " +
                     result.value("machine", "") + "; " + result.value("compiler", "") + "\n```\n\n" +
                     stability_summary(result) + ".\n";
  std::string group;
  for (const firmware::Json& row : result.value("figures", firmware::Json::array())) {
    if (row.value("group", "") != group) {
      group = row.value("group", "");
      text += "\n## " + group +
              "\n\n| case | measured | bound | ours | naive | |\n|---|---|---:|---:|---:|---|\n";
    }
    text += "| " + row.value("what", "") + " | " + row.value("measured", "");
    for (const char* key : {"bound", "ours", "naive"}) text += " | " + stability_figure(row, key);
    text += " | " + stability_verdict(row) + " |\n";
  }
  if (const std::string kernels = tables_page(result, "kernels"); !kernels.empty()) {
    text +=
        "\n## Kernels in float and double\n\nLargest error against quad precision, relative to the result's "
        "largest number, over 4096 random inputs (seed 7), and processor time of a call, best of seven "
        "rounds. "
        "A float's last half step is 6.0e-8, a double's 1.1e-16. *need*: what the runtime has to promise, in "
        "the "
        "same unit; *float is enough* compares the float's largest error with it. *in the runtime*: the "
        "precision "
        "that runs; where it is double, float and the quad are the same formula written once more. The "
        "profile "
        "chooses for the attitude filter (`attitude.precision`). The normal is solved alone here, in the map "
        "up to "
        "64 together.\n" +
        kernels;
  }
  return text;
}

}  // namespace

PeerFront stability_front() {
  PeerFront front;
  front.name = "stability";
  front.file = "bench-stability";
  front.about = "Stiff and extreme cases: ours within a bound, the naive method not";
  front.footer =
      "Exit code 0: every bound lies between ours and the naive method, 1: one does not. docs/stability.md\n"
      "tells what each case is.\n"
      "Examples:\n"
      "  sortie bench stability\n"
      "  sortie bench stability --only planner --json\n"
      "  sortie bench stability --out out/stability";
  front.options = {choice("--only", "Cases of one part alone",
                          {"rt", "drivers", "estimators", "mapping", "planner", "hil"})};
  front.has_passes = false;
  front.is_good = all_met;
  front.print = print_stability;
  front.page = stability_page;
  return front;
}

}  // namespace sortie::toolchain
