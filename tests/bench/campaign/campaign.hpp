// SPDX-License-Identifier: BSD-3-Clause
// The random campaign: sequences of hostile inputs for every module, drawn from a seed, checked, and reduced
// to a small one when a check fails. modules.cpp is the table of modules.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sortie::bench {

/// Numbers that one operation carries.
inline constexpr std::size_t kCampaignValues = 7;

/// One small operation of a sequence. What it does is the module's affair; every value of every member is
/// legal.
struct CampaignOp {
  std::uint32_t kind{};             ///< below the module's `kinds`; the module takes any modulo that
  std::int64_t step_ns{};           ///< what the stamp moves by before the operation
  double value[kCampaignValues]{};  ///< about -1..1 where they are not hostile; modules scale them
};
bool operator==(const CampaignOp& a, const CampaignOp& b);

/// What a sequence led to. accepted + refused = given, or there is a fault.
struct CampaignOutcome {
  std::string fault;  ///< the first check that failed, without figures: two of a kind read alike; empty: none
  std::uint64_t digest{};  ///< over all outputs
  std::uint64_t given{};
  std::uint64_t accepted{};
  std::uint64_t refused{};
  std::uint64_t checks{};  ///< made
};

/// Runs one sequence from the module's beginning.
using CampaignRun = std::function<CampaignOutcome(std::span<const CampaignOp>)>;

/// One module under trial.
struct CampaignModule {
  const char* group;  ///< folder of the code
  const char* name;   ///< one word, for --only
  const char* tries;  ///< what an operation is
  const char* keeps;  ///< what is checked, beside finite outputs, counts, heap and the same digest twice
  std::uint32_t kinds;
  std::uint32_t longest;   ///< most operations of a sequence
  std::int64_t period_ns;  ///< the step of calm operations
  std::uint32_t share;     ///< sequences for each 100 of the campaign's count: dear modules have fewer
  CampaignOutcome (*run)(std::span<const CampaignOp>);
};

/// All modules.
std::span<const CampaignModule> campaign_modules();
/// The one of this name, or null.
const CampaignModule* find_campaign_module(const std::string& name);

/// Sequence number `number` of a seed: calm or hostile (NaN, infinities, denormals, ends of the range, wild,
/// repeated and backward stamps, repeated and exchanged operations), 1 to `longest` operations. The same
/// everywhere.
std::vector<CampaignOp> draw_sequence(const CampaignModule& module, std::uint64_t seed, std::uint64_t number);

/// Runs a sequence twice; another digest the second time is a fault, too.
CampaignOutcome try_sequence(const CampaignModule& module, std::span<const CampaignOp> ops);

/// A failing sequence made small: no operation can be left out, and no number made simpler (0, 1, whole,
/// fewer digits; the calm step), without losing its fault. At most `most_runs` runs; `runs` tells how many.
std::vector<CampaignOp> shrink_sequence(std::vector<CampaignOp> ops, std::int64_t period_ns,
                                        const CampaignRun& run, std::uint64_t most_runs, std::uint64_t& runs);

/// A sequence as text, numbers exact, and back. Reading throws std::invalid_argument with the line.
std::string sequence_text(const std::string& module, std::span<const CampaignOp> ops);
std::vector<CampaignOp> read_sequence(const std::string& text, std::string& module);

/// What became of one module.
struct CampaignResult {
  const CampaignModule* module{};
  std::uint64_t sequences{};
  std::uint64_t operations{};
  CampaignOutcome sum;     ///< counts of all sequences; digest chained over them; fault: the first one's
  std::uint64_t failed{};  ///< sequences with a fault
  std::uint64_t failing_number{};   ///< of the first
  std::vector<CampaignOp> reduced;  ///< the first, shrunk
  std::uint64_t shrink_runs{};
};

/// Where a campaign is, for one that dies.
struct CampaignPlace {
  const char* module{""};
  std::uint64_t number{};
};

/// Runs `count` * share / 100 sequences of a module (at least one), or until the first fault.
CampaignResult run_campaign(const CampaignModule& module, std::uint64_t seed, std::uint64_t count,
                            CampaignPlace* place = nullptr);

}  // namespace sortie::bench
