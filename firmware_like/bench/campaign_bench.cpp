// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/campaign_bench.hpp"

#include <ostream>

#include "firmware_like/bench/peer_program.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kCampaignCounts[] = {"sequences", "operations", "given",
                                           "accepted",  "refused",    "checks"};

std::string campaign_count(const Json& row, const char* key) {
  return std::to_string(row.value(key, std::uint64_t{0}));
}

std::string campaign_summary(const Json& result) {
  const Json rows = result.value("figures", Json::array());
  std::uint64_t failed = 0;
  std::uint64_t operations = 0;
  for (const Json& row : rows) {
    failed += row.value("met", false) ? 0 : 1;
    operations += row.value("operations", std::uint64_t{0});
  }
  const Json settings = result.value("settings", Json::object());
  return "seed " + campaign_count(settings, "seed") + ": " + std::to_string(rows.size()) + " modules, " +
         std::to_string(operations) + " operations, " + std::to_string(failed) + " modules with a fault";
}

}  // namespace

Json run_campaign_bench(const CampaignBenchOptions& options) {
  PeerProgram program{
      "sortie-bench-campaign", options.program, {"--count", std::to_string(options.count)}, -1};
  const auto add = [&program](const char* option, const std::string& value) {
    program.arguments.insert(program.arguments.end(), {option, value});
  };
  if (options.seed) add("--seed", std::to_string(*options.seed));
  if (!options.only.empty()) add("--only", options.only);
  if (!options.replay.empty()) add("--replay", options.replay);
  return run_peer_program(program);
}

bool is_faultless(const Json& result) {
  const Json figures = result.value("figures", Json::array());
  for (const Json& row : figures) {
    if (!row.value("met", false)) return false;
  }
  return !figures.empty();
}

void print_campaign_bench(std::ostream& out, const Json& result) {
  out << pad_right("module", 26);
  for (const char* key : kCampaignCounts) out << pad_left(key, 12);
  out << "\n";
  for (const Json& row : result.value("figures", Json::array())) {
    out << pad_right(row.value("group", "") + " " + row.value("module", ""), 26);
    for (const char* key : kCampaignCounts) out << pad_left(campaign_count(row, key), 12);
    out << (row.value("met", false) ? "  kept" : "  FAULT") << "\n";
    if (!row.value("met", false)) {
      out << "\n"
          << row.value("fault", "") << "\nRun it again with --replay FILE, where FILE holds:\n\n"
          << row.value("sequence", "") << "\n";
    }
  }
  out << "\n" << campaign_summary(result) << "\n";
}

std::string campaign_bench_page(const Json& result, const std::string& command) {
  std::string text =
      "# Random campaign\n\nWritten by `" + command +
      "`. Sequences of hostile inputs for every module, drawn from the seed, each run twice. "
      "[What is drawn and checked](../stability.md#random-campaign).\n\n```\nmachine   " +
      result.value("machine", "") + "; " + result.value("compiler", "") + "\n```\n\n" +
      campaign_summary(result) +
      ".\n\n| module | sequences | operations | given | accepted | refused | checks | digest | |\n"
      "|---|---:|---:|---:|---:|---:|---:|---|---|\n";
  for (const Json& row : result.value("figures", Json::array())) {
    text += "| " + row.value("group", "") + " " + row.value("module", "");
    for (const char* key : kCampaignCounts) text += " | " + campaign_count(row, key);
    text += " | " + row.value("digest", "") + " | " +
            (row.value("met", false) ? "kept" : "FAULT: " + row.value("fault", "")) + " |\n";
  }
  text += "\n| module | an operation is | what is checked |\n|---|---|---|\n";
  for (const Json& row : result.value("figures", Json::array()))
    text += "| " + row.value("module", "") + " | " + row.value("tries", "") + " | " + row.value("keeps", "") +
            " |\n";
  return text;
}

}  // namespace sortie::firmware
