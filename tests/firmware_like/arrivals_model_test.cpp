// SPDX-License-Identifier: BSD-3-Clause
// The times of arrival in every interleaving of the thread that notes and the one that looks them up, under
// the memory model of C++.
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "firmware_like/runtime/arrivals.hpp"
#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {
namespace {

// Samples from number `kFirst` on arrive at ten times their number. The other thread has heard of all numbers
// up to one that was noted, and finds the time or none.
constexpr std::uint64_t kFirst = 5;

Result look_up(std::uint64_t notes, bool stop_at_failure) {
  using Modelled2 = firmware::BasicArrivals<Modelled>;
  std::unique_ptr<Modelled2> arrivals;
  Explorer& explorer = Explorer::instance();
  const auto look = [&](bool must_be_there) {
    for (std::uint64_t sequence = kFirst - 1; sequence <= kFirst + notes; ++sequence) {
      Nanoseconds time = -1;
      const bool found = arrivals->find(sequence, time);
      if (found && time != static_cast<Nanoseconds>(10 * sequence)) explorer.fail();
      if (must_be_there && found != (sequence == kFirst + notes - 1)) explorer.fail();
    }
  };
  const std::uint64_t executions =
      explorer.explore([&] { arrivals = std::make_unique<Modelled2>(2); },
                       [&] {
                         for (std::uint64_t i = 0; i < notes; ++i)
                           arrivals->note(kFirst + i, static_cast<Nanoseconds>(10 * (kFirst + i)));
                       },
                       [&] { look(false); }, [&] { look(true); }, stop_at_failure);
  return {executions, explorer.failures()};
}

}  // namespace

TEST_CASE("a time of arrival is the sample's own or none, and each memory order of that is needed",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order([](bool stop) { return look_up(3, stop); });
  INFO(plants.as_it_is.executions << " executions");
  CHECK(plants.as_it_is.executions > 100);
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught ==
        Names{"find: load acquire", "find: load acquire", "note: store release", "note: store release"});
}

}  // namespace sortie::rt::test
