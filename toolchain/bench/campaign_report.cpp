// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

constexpr const char* kCampaignCounts[] = {"sequences", "operations", "given",
                                           "accepted",  "refused",    "checks"};

std::string campaign_count(const firmware::Json& row, const char* key) {
  return std::to_string(row.value(key, std::uint64_t{0}));
}

std::string campaign_summary(const firmware::Json& result) {
  const firmware::Json rows = result.value("figures", firmware::Json::array());
  std::uint64_t failed = 0;
  std::uint64_t operations = 0;
  for (const firmware::Json& row : rows) {
    failed += row.value("met", false) ? 0 : 1;
    operations += row.value("operations", std::uint64_t{0});
  }
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return "seed " + campaign_count(settings, "seed") + ": " + std::to_string(rows.size()) + " modules, " +
         std::to_string(operations) + " operations, " + std::to_string(failed) + " modules with a fault";
}

void print_campaign(std::ostream& out, const firmware::Json& result, bool) {
  out << firmware::pad_right("module", 26);
  for (const char* key : kCampaignCounts) out << firmware::pad_left(key, 12);
  out << "\n";
  for (const firmware::Json& row : result.value("figures", firmware::Json::array())) {
    out << firmware::pad_right(row.value("group", "") + " " + row.value("module", ""), 26);
    for (const char* key : kCampaignCounts) out << firmware::pad_left(campaign_count(row, key), 12);
    out << (row.value("met", false) ? "  kept" : "  FAULT") << "\n";
    if (!row.value("met", false)) {
      out << "\n"
          << row.value("fault", "") << "\nRun it again with --replay FILE, where FILE holds:\n\n"
          << row.value("sequence", "") << "\n";
    }
  }
  out << "\n" << campaign_summary(result) << "\n";
}

std::string campaign_page(const firmware::Json& result, const std::string& command) {
  std::string text =
      "# Random campaign\n\nWritten by `" + command +
      "`. Sequences of hostile inputs for every module, drawn from the seed, each run twice. "
      "[What is drawn and checked](../stability.md#random-campaign).\n\n```\nmachine   " +
      result.value("machine", "") + "; " + result.value("compiler", "") + "\n```\n\n" +
      campaign_summary(result) +
      ".\n\n| module | sequences | operations | given | accepted | refused | checks | digest | |\n"
      "|---|---:|---:|---:|---:|---:|---:|---|---|\n";
  for (const firmware::Json& row : result.value("figures", firmware::Json::array())) {
    text += "| " + row.value("group", "") + " " + row.value("module", "");
    for (const char* key : kCampaignCounts) text += " | " + campaign_count(row, key);
    text += " | " + row.value("digest", "") + " | " +
            (row.value("met", false) ? "kept" : "FAULT: " + row.value("fault", "")) + " |\n";
  }
  text += "\n| module | an operation is | what is checked |\n|---|---|---|\n";
  for (const firmware::Json& row : result.value("figures", firmware::Json::array()))
    text += "| " + row.value("module", "") + " | " + row.value("tries", "") + " | " + row.value("keeps", "") +
            " |\n";
  return text;
}

}  // namespace

PeerFront campaign_front() {
  PeerFront front;
  front.name = "campaign";
  front.file = "bench-campaign";
  front.about = "Hostile random sequences for every module";
  front.footer =
      "Exit code 0: finite, bounded, counted, no heap, the same digest twice, in every module; 1: a fault, "
      "which\n"
      "is printed as a small sequence to run again. docs/stability.md tells what is drawn and checked.\n"
      "Examples:\n"
      "  sortie bench campaign\n"
      "  sortie bench campaign --only attitude --count 100000 --seed 7\n"
      "  sortie bench campaign --replay fault.txt";
  front.options = {
      {"--only", std::string(), "One module alone", 0, 0, {}, "MODULE"},
      {"--count", std::uint64_t{1000}, "Sequences of a cheap module; dear ones have a share of it", 1, 1e9},
      {"--seed", std::optional<std::uint64_t>(), "Of all sequences; a fresh one unless given", 0, 9e15},
      {"--replay", std::string(), "Run the sequence in this file instead", 0, 0, {}, "FILE"}};
  front.has_passes = false;
  front.is_good = all_met;
  front.print = print_campaign;
  front.page = campaign_page;
  return front;
}

}  // namespace sortie::toolchain
