// SPDX-License-Identifier: BSD-3-Clause
// Faults of one stream of messages: in the number that was asked for, and one fault does not move another.
#include "hil/fault_injection.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace sortie::hil {
namespace {

constexpr rt::Nanoseconds kMessageEvery = 5 * rt::kNanosecondsPerMillisecond;

std::vector<Fault> fates(const FaultConfig& config, std::uint64_t seed, int messages) {
  FaultInjector injector(config, seed, 7);
  std::vector<Fault> result;
  for (int i = 0; i < messages; ++i) result.push_back(injector.next(i * kMessageEvery));
  return result;
}

}  // namespace

TEST_CASE("faults: stamps jitter by the sigma that was asked for, never by more than four") {
  const std::uint64_t seed = 11;
  CAPTURE(seed);
  FaultConfig config;
  config.jitter_ns = 2e5;
  const int n = 20000;
  double sum = 0.0;
  double squares = 0.0;
  double lag_products = 0.0;
  double before = 0.0;
  for (const Fault& fault : fates(config, seed, n)) {
    const auto offset = static_cast<double>(fault.stamp_offset_ns);
    CHECK(std::abs(offset) <= 8e5);
    sum += offset;
    squares += offset * offset;
    lag_products += offset * before;
    before = offset;
    CHECK_FALSE(fault.drop);
  }
  CHECK(std::abs(sum / n) < 4 * 2e5 / std::sqrt(n));  // four standard errors of the mean
  CHECK(std::abs(squares / n / 4e10 - 1.0) <
        4 * std::sqrt(2.0 / n) + 2e-3);                        // and of the variance; the cut costs 0.1 %
  CHECK(std::abs(lag_products / squares) < 4 / std::sqrt(n));  // one stamp's error says nothing of the next
}

TEST_CASE("faults: an outage lasts as long as it was told to, and its messages count as dropped") {
  const std::uint64_t seed = 12;
  CAPTURE(seed);
  FaultConfig config;
  config.outage = 0.01;
  config.outage_ns = 50 * rt::kNanosecondsPerMillisecond;  // ten messages
  FaultInjector injector(config, seed, 7);
  int run = 0;
  std::uint64_t runs = 0;
  std::uint64_t dropped = 0;
  for (int i = 0; i < 20000; ++i) {
    const bool silent = injector.next(i * kMessageEvery).drop;
    dropped += silent ? 1 : 0;
    if (silent) {
      ++run;
    } else if (run > 0) {
      CHECK(run % 10 == 0);  // two that follow each other at once look like a long one
      runs += static_cast<std::uint64_t>(run / 10);
      run = 0;
    }
  }
  CHECK(injector.counters().outages - runs <= 1);  // the last may not be over
  CHECK(injector.counters().dropped == dropped);
  // A renewal process: one begins after 100 messages on average and takes ten.
  const double expected = 20000.0 / 110.0;
  CHECK(std::abs(static_cast<double>(injector.counters().outages) - expected) < 4 * std::sqrt(expected));
}

TEST_CASE("faults: jitter and outages leave the other faults' messages as they were") {
  FaultConfig plain;
  plain.drop = 0.1;
  plain.duplicate = 0.1;
  plain.saturate = 0.1;
  FaultConfig more = plain;
  more.jitter_ns = 1e6;
  more.outage = 0.05;
  more.outage_ns = 3 * kMessageEvery;
  const auto a = fates(plain, 13, 5000);
  const auto b = fates(more, 13, 5000);
  int kept = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (b[i].drop) continue;  // its own drop, or an outage
    ++kept;
    CHECK_FALSE(a[i].drop);
    CHECK(a[i].duplicate == b[i].duplicate);
    CHECK(a[i].saturate == b[i].saturate);
    CHECK(a[i].stamp_offset_ns == 0);
  }
  CHECK(kept > 3000);
}

}  // namespace sortie::hil
