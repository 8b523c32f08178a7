// SPDX-License-Identifier: BSD-3-Clause
// Misses in all, in a row and against a promise, beside a window of plain bools.
#include "rt/miss_window.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <deque>
#include <random>

namespace sortie::rt {

TEST_CASE("misses are counted as a plain window of the last k releases counts them") {
  constexpr std::uint32_t kSeed = 4711;
  INFO("seed " << kSeed);
  std::minstd_rand random(kSeed);
  for (int round = 0; round < 200; ++round) {
    const auto k = static_cast<std::uint8_t>(1 + random() % 64);
    const auto m = static_cast<std::uint8_t>(random() % (k + 1u));
    MissWindow window(FirmPromise{m, k});
    std::deque<bool> last(k, true);
    std::uint64_t missed = 0;
    std::uint64_t in_row = 0;
    std::uint64_t worst = 0;
    std::uint64_t broken = 0;
    bool holds = true;
    const std::uint32_t often = 1 + random() % 8;
    const auto step = [&](bool met) {
      last.pop_front();
      last.push_back(met);
      missed += met ? 0u : 1u;
      in_row = met ? 0 : in_row + 1;
      worst = std::max(worst, in_row);
      const auto met_ones = static_cast<std::uint32_t>(std::count(last.begin(), last.end(), true));
      const bool now_holds = met_ones >= m;
      const bool breaks = holds && !now_holds;
      broken += breaks ? 1u : 0u;
      holds = now_holds;
      return breaks;
    };
    for (int i = 0; i < 300; ++i) {
      if (random() % 40 == 0) {
        const std::uint64_t many = random() % 200;
        bool breaks = false;
        for (std::uint64_t j = 0; j < many; ++j) breaks = step(false) || breaks;
        REQUIRE(window.note_missed(many) == breaks);
      } else {
        const bool met = random() % often != 0;
        const bool breaks = step(met);
        REQUIRE(window.note(met) == breaks);
      }
      REQUIRE(window.missed() == missed);
      REQUIRE(window.in_row() == in_row);
      REQUIRE(window.worst_in_row() == worst);
      REQUIRE(window.broken() == broken);
    }
  }
}

TEST_CASE("without a promise nothing is broken, and a million million skipped releases cost one window") {
  MissWindow window;
  CHECK_FALSE(window.note_missed(1'000'000'000'000));
  CHECK(window.missed() == 1'000'000'000'000);
  CHECK(window.worst_in_row() == 1'000'000'000'000);
  CHECK(window.broken() == 0);
}

}  // namespace sortie::rt
