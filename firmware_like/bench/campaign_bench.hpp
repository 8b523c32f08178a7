// SPDX-License-Identifier: BSD-3-Clause
// The random campaign: a program of its own (sortie-bench-campaign) that is found, run and shown here.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "firmware_like/json.hpp"

namespace sortie::firmware {

/// What to run.
struct CampaignBenchOptions {
  std::string only;                   ///< one module alone
  std::uint64_t count{1000};          ///< sequences of a cheap module; dear ones have a share of it
  std::optional<std::uint64_t> seed;  ///< none: a fresh one, which the result tells
  std::string replay;                 ///< file with a sequence that is run instead
  std::string program;  ///< sortie-bench-campaign, if it is not where a build or an installation puts it
};

/// Runs the campaign (seed and modules go to stderr) and returns the program's object, with machine, compiler
/// and the doctor's verdict added. Throws BenchRefused with the cure.
Json run_campaign_bench(const CampaignBenchOptions& options);

/// True when no module has a fault.
bool is_faultless(const Json& result);

/// One line a module: sequences, operations, accepted, refused, verdict; then what failed, as text to run
/// again.
void print_campaign_bench(std::ostream& out, const Json& result);

/// The same as a Markdown page, with `command` as how to get it again.
std::string campaign_bench_page(const Json& result, const std::string& command);

}  // namespace sortie::firmware
