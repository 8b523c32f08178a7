// SPDX-License-Identifier: BSD-3-Clause
// Verdicts and the values that they guard in every interleaving of a writer and its readers, under the memory
// model of C++. Each memory order is taken away once: all words are atomic, so no sanitizer could miss it,
// and x86 has it anyway.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "rt/ledger.hpp"
#include "rt/let_channel.hpp"
#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {
namespace {

using ModelledLedger = BasicJobLedger<Modelled>;

// Words of the ledger of two jobs a lap, and the ledger.
struct Verdicts {
  std::array<Modelled<std::uint32_t>, 2> words;
  ModelledLedger ledger{words.data(), 2};
};

// A writer runs one job; `readers` ask for its verdict. All obey one verdict, and whoever sees done sees what
// the job wrote before.
Result one_verdict(int readers, bool stop_at_failure) {
  std::unique_ptr<Verdicts> verdicts;
  std::unique_ptr<Tracked> output;
  std::array<Verdict, 3> said{};
  Explorer& explorer = Explorer::instance();
  std::vector<std::function<void()>> bodies{[&] {
    said[0] = Verdict::missed;
    if (!verdicts->ledger.begin(5)) return;
    output->write(55);
    said[0] = verdicts->ledger.finish(5, true);
  }};
  for (int reader = 1; reader <= readers; ++reader) {
    bodies.emplace_back([&, reader] {
      Verdict& mine = said[static_cast<std::size_t>(reader)];
      mine = verdicts->ledger.decide(5);
      if (mine == Verdict::done && output->read() != 55) explorer.fail();
    });
  }
  const std::uint64_t executions = explorer.explore(
      [&] {
        verdicts = std::make_unique<Verdicts>();
        output = std::make_unique<Tracked>(0);
      },
      bodies,
      [&] {
        for (int reader = 1; reader <= readers; ++reader) {
          if (said[static_cast<std::size_t>(reader)] != said[0]) explorer.fail();
        }
        if (said[0] != Verdict::done && said[0] != Verdict::missed) explorer.fail();
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

// Two words that belong together.
struct Pair {
  std::uint32_t number{};
  std::uint32_t twin{};
};

// Job 1 has been done; a writer runs the jobs up to `last` into the same slot of a ring of one, and a reader
// asks for `asked`, one after another. What it is given is the job's own, whole, or nothing.
Result one_slot(std::uint64_t last, const std::vector<std::uint64_t>& asked, bool stop_at_failure) {
  using Channel = LetChannel<Pair, Modelled>;
  struct Slot {
    std::array<Modelled<std::uint32_t>, 1> verdict;
    std::array<Modelled<std::uint32_t>, Channel::kWords> words;
    ModelledLedger ledger{verdict.data(), 1};
    Channel channel{ledger, words.data()};
    void run(std::uint64_t job) {
      const auto number = static_cast<std::uint32_t>(job);
      if (!ledger.begin(job)) return;
      channel.write(job, job, {number, ~number});
      static_cast<void>(ledger.finish(job, true));
    }
  };
  std::unique_ptr<Slot> slot;
  Explorer& explorer = Explorer::instance();
  const std::uint64_t executions = explorer.explore(
      [&] {
        slot = std::make_unique<Slot>();
        slot->run(1);
      },
      [&] {
        for (std::uint64_t job = 2; job <= last; ++job) slot->run(job);
      },
      [&] {
        for (const std::uint64_t job : asked) {
          if (slot->ledger.decide(job) != Verdict::done) {
            // Nobody writes behind a verdict: a word of a later job means that this one was overtaken.
            static_cast<void>(slot->ledger.overtook(job));
            continue;
          }
          Pair value{77, 77};
          std::uint64_t made_by = 77;
          if (!slot->channel.read(job, value, made_by)) {
            if (value.number != 77 || value.twin != 77 || made_by != 77) explorer.fail();
          } else if (value.number != job || value.twin != ~value.number || made_by != job) {
            explorer.fail();
          }
        }
      },
      [] {}, stop_at_failure);
  return {executions, explorer.failures()};
}

Result ledger(bool stop_at_failure) {
  return one_verdict(1, stop_at_failure) + one_verdict(2, stop_at_failure);
}
Result channel(bool stop_at_failure) { return one_slot(2, {1, 2}, stop_at_failure); }

}  // namespace

TEST_CASE("one verdict is obeyed in any interleaving, and each memory order of that is needed", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order(ledger);
  INFO(plants.as_it_is.executions << " executions");
  CHECK(plants.as_it_is.executions > 100);
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"decide: load acquire", "finish: compare_exchange release"});
}

TEST_CASE("a value is that of the job that was asked for, whole, or none, in any interleaving of two jobs",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = one_slot(3, {2}, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 100'000);
  CHECK(result.failures == 0);
}

TEST_CASE("each memory order of a channel is needed, and its loss is caught", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order(channel);
  INFO(plants.as_it_is.executions << " executions");
  CHECK(plants.as_it_is.executions > 10'000);
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"decide: load acquire", "finish: compare_exchange release",
                               "load_words: load acquire", "read: load acquire", "store_words: store release",
                               "write: store release"});
}

}  // namespace sortie::rt::test
