// SPDX-License-Identifier: BSD-3-Clause
// The log of intervals in every interleaving of its writer and a reader, under the memory model of C++.
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "rt/posix/interval_log.hpp"
#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {
namespace {

// Intervals of weight 1 begin at 10, 20, 30, ...; each is covered when it has been added. A reader finds all
// that lie before the covered time.
Result covered(Nanoseconds adds, bool stop_at_failure) {
  using Log = posix::BasicIntervalLog<4, Modelled>;
  std::unique_ptr<Log> log;
  Explorer& explorer = Explorer::instance();
  const auto write = [&] {
    for (Nanoseconds i = 1; i <= adds; ++i) {
      log->add(10 * i, 10 * i + 1, 1);
      log->cover(10 * i + 2);
    }
  };
  const auto look = [&] {
    const Nanoseconds until = log->covered_until();
    if (static_cast<Nanoseconds>(log->weight(0, until)) != until / 10) explorer.fail();
  };
  const std::uint64_t executions =
      explorer.explore([&] { log = std::make_unique<Log>(); }, write, look, look, stop_at_failure);
  return {executions, explorer.failures()};
}

}  // namespace

TEST_CASE("no interval before the covered time is missed, and each memory order of that is needed",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order([](bool stop) { return covered(2, stop); });
  INFO(plants.as_it_is.executions << " executions");
  CHECK(plants.as_it_is.executions > 100);
  CHECK(plants.as_it_is.failures == 0);
  // The words' own orders: queue_overwrite_model_test.cpp needs them, here nothing is written over.
  CHECK(plants.missed == Names{"load_words: load acquire", "store_words: store release"});
  CHECK(plants.caught == Names{"cover: store release", "covered_until: load acquire", "end: load acquire",
                               "push: store release"});
}

}  // namespace sortie::rt::test
