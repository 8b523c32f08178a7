// SPDX-License-Identifier: BSD-3-Clause
// What a decision costs and is worth: over the number of choices, and over the share of masked cells.
#include <cmath>
#include <memory>
#include <stdexcept>

#include "rt/posix/clock.hpp"
#include "tests/bench/flippers/flipper_parts.hpp"
#include "tests/planner/flipper_twin.hpp"

namespace sortie::bench {
namespace {
using namespace planner;

/// To so many parts of one.
double to(double value, double parts) { return std::round(value * parts) / parts; }

double timed_search(FlipperSearch& search, const DrawnQuestion& drawn, FlipperFound& found) {
  const rt::Nanoseconds begin = rt::posix::thread_cpu_now();
  if (search.search(drawn.ground.view(), drawn.question, found) != Status::ok)
    throw std::runtime_error("flippers: no answer on a course");
  return 1e-6 * static_cast<double>(rt::posix::thread_cpu_now() - begin);
}

}  // namespace

void measure_flipper_search(const FlipperSettings& settings, Report& report) {
  const int cases = settings.cases_or(100);
  std::vector<DrawnQuestion> drawn;
  std::vector<std::unique_ptr<FlipperTwin>> twins;
  std::vector<TwinJudgement> best;
  for (int k = 0; k < cases; ++k) {
    drawn.push_back(drawn_question(settings.seed + static_cast<std::uint64_t>(k)));
    if (!drawn.back().stands) {
      drawn.pop_back();
      continue;
    }
    FlipperTwin twin(FlipperSearchConfig{}, drawn.back().ground.view(), drawn.back().question);
    best.push_back(twin.best_of_grid());
  }
  Json rows = Json::array();
  for (const std::uint32_t most : {1u, 5u, 10u, 20u, 40u, 120u}) {
    FlipperSearchConfig config;
    config.most_tried = most;
    const auto search = std::make_unique<FlipperSearch>(posture_vehicle({}), config);
    Rounds ms, units, ratio;
    int missed = 0;
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      FlipperFound found;
      ms.add(timed_search(*search, drawn[k], found));
      units.add(found.units);
      if (!best[k].safe) continue;
      if (found.best.probability > 0.0)
        ++missed;
      else
        ratio.add(found.best.cost / best[k].cost);
    }
    rows.push_back({most, drawn.size(), to(ms.median(), 100), to(ms.quantile(0.99), 100),
                    std::round(units.median()), std::round(units.high()), to(ratio.median(), 1000),
                    to(ratio.quantile(0.9), 1000), missed});
  }
  report.add_table("search",
                   {"most tried", "n", "ms p50", "p99", "units p50", "most", "cost p50 of the grid's best",
                    "p90", "safe choice missed"},
                   rows);
  report.note("search", "All cells known. The grid: all 169 pairs of front and rear angles, by a twin.");
}

void measure_flipper_masks(const FlipperSettings& settings, Report& report) {
  const int cases = settings.cases_or(200);
  Json rows = Json::array();
  const auto search = std::make_unique<FlipperSearch>(posture_vehicle({}), FlipperSearchConfig{});
  for (const int patch : {1, 4}) {
    for (const double share : {0.0, 0.1, 0.3, 0.6}) {
      Rounds ms, units;
      int n = 0, safe = 0, safe_unmasked = 0, wrong = 0, probable = 0, probable_wrong = 0;
      double told = 0.0;
      for (int k = 0; k < cases; ++k) {
        const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(k);
        DrawnQuestion drawn = drawn_question(seed);
        if (!drawn.stands) continue;
        ++n;
        FlipperTwin twin(FlipperSearchConfig{}, drawn.ground.view(), drawn.question);
        FlipperFound found;
        (void)timed_search(*search, drawn, found);
        if (found.best.probability == 0.0) ++safe_unmasked;
        hil::Random random(seed, 0x6d61736b);
        drawn.ground.mask(share, patch, random);
        ms.add(timed_search(*search, drawn, found));
        units.add(found.units);
        const bool bad = !twin.judge(found.best.angles).safe;
        if (found.best.probability == 0.0) {
          ++safe;
          if (bad) ++wrong;
        } else if (found.under.open == 0) {
          ++probable;
          told += found.best.probability;
          if (bad) ++probable_wrong;
        }
      }
      rows.push_back({std::round(100 * share), patch, n, safe_unmasked, safe, wrong, probable,
                      probable > 0 ? to(told / probable, 100) : 0.0, probable_wrong, to(ms.median(), 100),
                      to(ms.quantile(0.99), 100), std::round(units.high())});
    }
  }
  report.add_table("masked",
                   {"masked %", "patch, cells", "n", "safe with all cells", "safe as told",
                    "not safe in truth", "told not safe, all bounded", "mean probability told",
                    "not safe in truth", "ms p50", "p99", "most units"},
                   rows);
  report.note(
      "masked",
      "Patches of so many cells an edge are forgotten. Truth: the same angles on the unmasked ground, by "
      "a twin.");
}

}  // namespace sortie::bench
