// SPDX-License-Identifier: BSD-3-Clause
// A module's share of the campaign.
#include <algorithm>

#include "rt/digest.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

CampaignOutcome try_sequence(const CampaignModule& module, std::span<const CampaignOp> ops) {
  CampaignOutcome outcome = module.run(ops);
  if (outcome.fault.empty() && module.run(ops).digest != outcome.digest)
    outcome.fault = "the same sequence has another digest the second time";
  return outcome;
}

CampaignResult run_campaign(const CampaignModule& module, std::uint64_t seed, std::uint64_t count,
                            CampaignPlace* place) {
  constexpr std::uint64_t kMostShrinkRuns = 20'000;
  CampaignResult result;
  result.module = &module;
  const std::uint64_t wanted = std::max<std::uint64_t>(1, count * module.share / 100);
  for (std::uint64_t number = 0; number < wanted && result.failed == 0; ++number) {
    if (place != nullptr) *place = {module.name, number};
    const std::vector<CampaignOp> ops = draw_sequence(module, seed, number);
    const CampaignOutcome outcome = try_sequence(module, ops);
    ++result.sequences;
    result.operations += ops.size();
    result.sum.given += outcome.given;
    result.sum.accepted += outcome.accepted;
    result.sum.refused += outcome.refused;
    result.sum.checks += outcome.checks;
    result.sum.digest = rt::chain_digest(result.sum.digest, number, outcome.digest);
    if (outcome.fault.empty()) continue;
    ++result.failed;
    result.failing_number = number;
    result.sum.fault = outcome.fault;
    result.reduced = shrink_sequence(
        ops, module.period_ns,
        [&module](std::span<const CampaignOp> some) { return try_sequence(module, some); }, kMostShrinkRuns,
        result.shrink_runs);
  }
  return result;
}

}  // namespace sortie::bench
