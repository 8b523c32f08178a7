// SPDX-License-Identifier: BSD-3-Clause
// The random campaign with a fixed seed, what it is made of, and that it finds what is planted.
#include "tests/bench/campaign/campaign.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/bench/campaign/trial.hpp"

namespace {
using namespace sortie;
using bench::CampaignOp;

constexpr std::uint64_t kFixedSeed = 1;  // CI must not be unlucky; the command draws a fresh one

bench::CampaignOutcome square_sum(std::span<const CampaignOp> ops) {
  bench::CampaignTrial trial;
  double sum = 0;
  for (const CampaignOp& op : ops) {
    const double value = op.value[0];
    trial.count(std::isfinite(value));
    if (std::isfinite(value)) sum += value * value;  // the fault: the square may overflow
    trial.see(sum, "the sum is not finite");
  }
  return trial.end();
}

bench::CampaignOutcome with_heap(std::span<const CampaignOp> ops) {
  bench::CampaignTrial trial;
  for (const CampaignOp& op : ops) {
    trial.real_time([&] {
      if (op.kind == 2) {
        const std::vector<double> taken(100 + ops.size(), op.value[0]);
        trial.fold(taken.size());
      }
      return 0;
    });
    trial.count(true);
  }
  return trial.end();
}

bench::CampaignOutcome with_memory(std::span<const CampaignOp> ops) {
  static std::uint64_t runs = 0;  // the fault: a run leaves something behind
  bench::CampaignTrial trial;
  trial.count(true);
  if (ops.size() > 3) trial.fold(++runs);
  return trial.end();
}

bench::CampaignOutcome miscounted(std::span<const CampaignOp> ops) {
  bench::CampaignTrial trial;
  std::uint64_t taken = 0;
  for (const CampaignOp& op : ops)
    taken += op.step_ns == 0 ? 0 : 1;  // the fault: refused ones are not counted
  trial.count_many(ops.size(), taken, 0);
  return trial.end();
}

constexpr bench::CampaignModule kSquares{"rt", "squares", "", "", 1, 100, 1000, 100, square_sum};
constexpr bench::CampaignModule kHeap{"rt", "heap", "", "", 4, 50, 1000, 100, with_heap};
constexpr bench::CampaignModule kMemory{"rt", "memory", "", "", 4, 50, 1000, 100, with_memory};
constexpr bench::CampaignModule kCounts{"rt", "counts", "", "", 4, 50, 1000, 100, miscounted};

int failing_modules(std::uint64_t count, bool dear) {
  int failing = 0;
  for (const bench::CampaignModule& module : bench::campaign_modules()) {
    if ((module.share < 40) != dear) continue;
    const bench::CampaignResult result = bench::run_campaign(module, kFixedSeed, count);
    if (result.failed == 0) continue;
    ++failing;
    UNSCOPED_INFO(module.name << ", seed " << kFixedSeed << ": " << result.sum.fault << "\n"
                              << bench::sequence_text(module.name, result.reduced));
  }
  return failing;
}

}  // namespace

TEST_CASE("Hostile random sequences: every module stays finite, bounded and counted") {
  CHECK(failing_modules(100, false) == 0);
  CHECK(failing_modules(20, true) == 0);
}

TEST_CASE("Ten times as many hostile random sequences", "[heavy]") {
  CHECK(failing_modules(1000, false) == 0);
  CHECK(failing_modules(200, true) == 0);
}

TEST_CASE("Modules of the campaign have names of their own, and most inputs of each are really tried") {
  std::set<std::string> names;
  for (const bench::CampaignModule& module : bench::campaign_modules()) {
    names.insert(module.name);
    CHECK(bench::find_campaign_module(module.name) == &module);
    const bench::CampaignResult result = bench::run_campaign(module, 7, 10);
    INFO(module.name);
    CHECK(result.sum.given > 0);
    CHECK(result.sum.accepted > 0);
    CHECK(result.sum.accepted + result.sum.refused == result.sum.given);
    CHECK(result.sum.checks > 0);
  }
  CHECK(names.size() == bench::campaign_modules().size());
  CHECK(bench::find_campaign_module("nobody") == nullptr);
}

TEST_CASE("A sequence is the same for the same seed, and another for another") {
  const auto ops = bench::draw_sequence(kSquares, 5, 3);
  CHECK(ops == bench::draw_sequence(kSquares, 5, 3));
  CHECK_FALSE(ops == bench::draw_sequence(kSquares, 5, 4));
  CHECK_FALSE(ops == bench::draw_sequence(kSquares, 6, 3));
  // Whatever was promised comes: over 300 sequences.
  bool nan = false, infinite = false, denormal = false, back = false, repeated = false, largest = false;
  for (std::uint64_t number = 0; number < 300; ++number) {
    for (const CampaignOp& op : bench::draw_sequence(kSquares, 5, number)) {
      back = back || op.step_ns < 0;
      repeated = repeated || op.step_ns == 0;
      for (const double value : op.value) {
        nan = nan || std::isnan(value);
        infinite = infinite || std::isinf(value);
        denormal = denormal || std::fpclassify(value) == FP_SUBNORMAL;
        largest = largest || value == std::numeric_limits<double>::max();
      }
    }
  }
  CHECK((nan && infinite && denormal && back && repeated && largest));
}

TEST_CASE("The campaign finds an overflow and reduces it to one operation with one number") {
  const bench::CampaignResult result = bench::run_campaign(kSquares, kFixedSeed, 1000);
  REQUIRE(result.failed == 1);
  CHECK(result.sum.fault == "the sum is not finite");
  REQUIRE(result.reduced.size() == 1);
  CHECK(result.reduced[0].step_ns == 1000);
  CHECK(std::fabs(result.reduced[0].value[0]) > 1.3e154);
  for (std::size_t i = 1; i < bench::kCampaignValues; ++i) CHECK(result.reduced[0].value[i] == 0.0);
  CHECK_FALSE(square_sum(result.reduced).fault.empty());
}

TEST_CASE("The campaign finds calls of the heap, a state left behind, and inputs that nobody counted") {
  if (rt::posix::kHeapTrapAvailable) {
    const bench::CampaignResult heap = bench::run_campaign(kHeap, kFixedSeed, 100);
    REQUIRE(heap.reduced.size() == 1);
    CHECK(heap.reduced[0].kind == 2);
  }
  const bench::CampaignResult memory = bench::run_campaign(kMemory, kFixedSeed, 100);
  CHECK(memory.sum.fault == "the same sequence has another digest the second time");
  CHECK(memory.reduced.size() == 4);
  const bench::CampaignResult counts = bench::run_campaign(kCounts, kFixedSeed, 1000);
  REQUIRE(counts.reduced.size() == 1);
  CHECK(counts.reduced[0].step_ns == 0);
}

TEST_CASE("The shrinker keeps exactly what a fault needs: one value, two in order, a number's size") {
  std::vector<CampaignOp> ops = bench::draw_sequence(kCounts, 3, 17);
  while (ops.size() < 40) ops.push_back({3, 77, {0.3, 0.4}});
  ops[20] = {2, 123, {0.1, 1234.5678, 0.2}};
  ops[31] = {1, 456, {5.5}};
  std::uint64_t runs = 0;
  // One value.
  const bench::CampaignRun one = [](std::span<const CampaignOp> some) {
    bench::CampaignOutcome outcome;
    for (const CampaignOp& op : some)
      if (op.value[1] == 1234.5678) outcome.fault = "one";
    return outcome;
  };
  const auto single = bench::shrink_sequence(ops, 1000, one, 100'000, runs);
  CHECK(single == std::vector<CampaignOp>{{0, 1000, {0.0, 1234.5678}}});
  // A first and, later, a second.
  const bench::CampaignRun two = [](std::span<const CampaignOp> some) {
    bench::CampaignOutcome outcome;
    bool first = false;
    for (const CampaignOp& op : some) {
      if (first && op.kind == 1 && op.value[0] > 5.0) outcome.fault = "two";
      first = first || (op.kind == 2 && op.value[1] > 1000.0);
    }
    return outcome;
  };
  const auto pair = bench::shrink_sequence(ops, 1000, two, 100'000, runs);
  REQUIRE(pair.size() == 2);
  CHECK(pair[0] == CampaignOp{2, 1000, {0.0, 1234.0}});
  CHECK(pair[1].kind == 1);
  CHECK(pair[1].value[0] < 5.6);
  // Nothing wrong: nothing is touched. No runs left: what was last is given back.
  const auto good = bench::shrink_sequence(
      ops, 1000, [](std::span<const CampaignOp>) { return bench::CampaignOutcome{}; }, 100, runs);
  CHECK(good == ops);
  CHECK(bench::shrink_sequence(ops, 1000, one, 0, runs) == ops);
}

TEST_CASE("A sequence comes back from its text to the last bit, and damaged text is refused with its line") {
  std::string name;
  for (std::uint64_t number = 0; number < 50; ++number) {
    const auto ops = bench::draw_sequence(kSquares, 11, number);
    CHECK(bench::read_sequence(bench::sequence_text("squares", ops), name) == ops);
    CHECK(name == "squares");
  }
  CHECK_THROWS_AS(bench::read_sequence("op 1 2 0 0 0 0 0 0 0\n", name), std::invalid_argument);
  CHECK_THROWS_AS(bench::read_sequence("module a\nop 1 2 0 0 0 x 0 0 0\n", name), std::invalid_argument);
  CHECK_THROWS_AS(bench::read_sequence("module a\nop 1 2 0 0 0 0 0 0\n", name), std::invalid_argument);
  CHECK_THROWS_AS(bench::read_sequence("module a\nop 1 2 0 0 0 0 0 0 0 0\n", name), std::invalid_argument);
  CHECK_THROWS_AS(bench::read_sequence("module a\nswim\n", name), std::invalid_argument);
}
