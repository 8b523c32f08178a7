// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/chain_watch.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

ChainFigures figures(const rt::LatencyHistogram& histogram) {
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; };
  return {histogram.count(), us(histogram.percentile(0.5)), us(histogram.percentile(0.99)),
          us(histogram.max())};
}

std::string ms(double us) { return format_short(us * 1e-3) + " ms"; }

std::string excess_text(std::uint64_t reactions, double reaction_us, double max_reaction_us,
                        std::uint64_t ages, double age_us, double max_age_us) {
  const auto part = [](const char* what, const char* key, std::uint64_t count, double us, double allowed_us) {
    return std::string(what) + " up to " + ms(us) + ", " + key + " allows " + ms(allowed_us) + ", " +
           std::to_string(count) + (count == 1 ? " time" : " times");
  };
  std::string text;
  if (reactions != 0) text = part("reaction", "max_reaction_ms", reactions, reaction_us, max_reaction_us);
  if (ages != 0)
    text += (text.empty() ? "" : "; ") + part("data age", "max_age_ms", ages, age_us, max_age_us);
  return text;
}

// A bound that nothing was measured against is not known to be kept.
void warn_unmeasured(Results& results, const ChainResult& chain) {
  const double allowed_us = std::max(chain.max_reaction_us, chain.max_age_us);
  const double length_us = static_cast<double>(results.ticks) * results.schedule.base_tick_us;
  if (allowed_us == 0 || chain.reaction.count + chain.age.count != 0 || length_us < 4 * allowed_us) return;
  results.warnings.push_back("chain " + chain.name + ": no output knew of a sample of " + chain.path.front() +
                             ", so its bounds were not measured");
}

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

ChainWatch::ChainWatch(const Runtime& runtime, bool on_run_clock) : runtime_(runtime) {
  for (const DeclaredChain& chain : runtime.chains()) {
    const ChainLimits limits{std::llround(chain.spec.max_reaction_ms * 1e6),
                             std::llround(chain.spec.max_age_ms * 1e6)};
    meters_.push_back(
        std::make_unique<ChainMeter>(runtime.executive(), chain.chain, chain.arrivals, on_run_clock, limits));
  }
  told_.resize(meters_.size());
}

std::uint64_t ChainWatch::over(std::size_t chain) const {
  return meters_[chain]->reactions_over() + meters_[chain]->ages_over();
}

std::string ChainWatch::excess(std::size_t chain) const {
  const ChainMeter& meter = *meters_[chain];
  const ChainSpec& spec = runtime_.chains()[chain].spec;
  const auto us = [](rt::Nanoseconds ns) { return static_cast<double>(ns) * 1e-3; };
  return excess_text(meter.reactions_over(), us(meter.reaction_over_ns()), spec.max_reaction_ms * 1e3,
                     meter.ages_over(), us(meter.age_over_ns()), spec.max_age_ms * 1e3);
}

std::vector<ChainNews> ChainWatch::take_news(rt::Nanoseconds now_ns) {
  constexpr rt::Nanoseconds kApart = 1'000'000'000;
  std::vector<ChainNews> news;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < meters_.size(); ++i) {
    const std::uint64_t count = over(i);
    if (count == told_[i].count || (told_[i].count != 0 && now_ns - told_[i].at_ns < kApart)) continue;
    told_[i] = {count, now_ns};
    news.push_back({runtime_.chains()[i].spec.name, excess(i)});
  }
  return news;
}

void ChainWatch::add_to(Results& results) const {
  for (std::size_t i = 0; i < meters_.size() && i < results.chains.size(); ++i) {
    const ChainMeter& meter = *meters_[i];
    ChainResult& chain = results.chains[i];
    chain.reaction = figures(meter.reaction());
    chain.age = figures(meter.age());
    // Of a part of the jobs it would be a figure that nobody asked for.
    if (results.live.known) chain.finished = figures(meter.finished());
    chain.source_interval_max_us = static_cast<double>(meter.source_interval_ns()) * 1e-3;
    chain.unmeasured = meter.unmeasured();
    chain.reactions_over = meter.reactions_over();
    chain.ages_over = meter.ages_over();
    chain.reaction_over_max_us = static_cast<double>(meter.reaction_over_ns()) * 1e-3;
    chain.age_over_max_us = static_cast<double>(meter.age_over_ns()) * 1e-3;
    results.counters["chain_bounds_exceeded"] += over(i);
    warn(results, chain);
    warn_unmeasured(results, chain);
  }
  for (std::string& line : exceeded_bounds(results)) results.warnings.push_back(std::move(line));
}

std::vector<std::string> exceeded_bounds(const Results& results) {
  std::vector<std::string> lines;
  for (const ChainResult& chain : results.chains) {
    if (chain.reactions_over + chain.ages_over == 0) continue;
    lines.push_back("chain " + chain.name + ": " +
                    excess_text(chain.reactions_over, chain.reaction_over_max_us, chain.max_reaction_us,
                                chain.ages_over, chain.age_over_max_us, chain.max_age_us));
  }
  return lines;
}

}  // namespace sortie::firmware
