// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/chain_watch.hpp"

#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

ChainFigures figures(const rt::LatencyHistogram& histogram) {
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; };
  return {histogram.count(), us(histogram.percentile(0.5)), us(histogram.percentile(0.99)),
          us(histogram.max())};
}

std::string ms(double us) { return format_short(us * 1e-3) + " ms"; }

// A figure beyond its bound, although every release was met, has a cause outside the table.
void warn(Results& results, const ChainResult& chain) {
  const double slow_us = chain.source_interval_max_us;
  if (chain.source_interval_us > 0 && slow_us > chain.source_interval_us) {
    results.warnings.push_back("chain " + chain.name + ": samples came up to " + ms(slow_us) +
                               " apart, source_interval_ms promises " + ms(chain.source_interval_us));
  }
  if (results.counters["missed_jobs"] + results.counters["skipped_releases"] +
          results.counters["shed_jobs"] !=
      0)
    return;
  // A driver stamps a sample a little before it pushes it; a tick is what polling may cost.
  if (chain.reaction.max_us > chain.reaction_us + results.schedule.base_tick_us) {
    results.warnings.push_back("chain " + chain.name + ": a sample took " + ms(chain.reaction.max_us) +
                               ", the table promises " + ms(chain.reaction_us) +
                               ": it waited before or in its stream");
  }
}

}  // namespace

ChainWatch::ChainWatch(const Runtime& runtime, bool on_run_clock) {
  for (const DeclaredChain& chain : runtime.chains()) {
    meters_.push_back(
        std::make_unique<ChainMeter>(runtime.executive(), chain.chain, chain.arrivals, on_run_clock));
  }
}

void ChainWatch::add_to(Results& results) const {
  for (std::size_t i = 0; i < meters_.size() && i < results.chains.size(); ++i) {
    const ChainMeter& meter = *meters_[i];
    ChainResult& chain = results.chains[i];
    chain.reaction = figures(meter.reaction());
    chain.age = figures(meter.age());
    chain.finished = figures(meter.finished());
    chain.source_interval_max_us = static_cast<double>(meter.source_interval_ns()) * 1e-3;
    chain.unmeasured = meter.unmeasured();
    warn(results, chain);
  }
}

}  // namespace sortie::firmware
