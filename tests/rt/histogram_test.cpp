// SPDX-License-Identifier: BSD-3-Clause
// The latency histogram against the sorted list of everything it was given.
#include "rt/histogram.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace sortie::rt {
namespace {

// Durations from 1 ns to 2^36 ns, each doubling as likely.
std::vector<std::uint64_t> durations(std::uint64_t seed, std::size_t count) {
  std::mt19937_64 engine(seed);
  std::vector<std::uint64_t> all;
  while (all.size() < count) {
    const std::uint64_t bits = engine();
    all.push_back((bits >> 28) >> (engine() % 37));
  }
  return all;
}

// The element that a share q of all does not exceed.
std::uint64_t exact_percentile(const std::vector<std::uint64_t>& sorted, double q) {
  const std::size_t n = sorted.size();
  for (std::size_t rank = 1; rank <= n; ++rank) {
    if (static_cast<double>(rank) >= q * static_cast<double>(n) - 1e-6) return sorted[rank - 1];
  }
  return sorted.back();
}

}  // namespace

TEST_CASE("percentiles are never below the sorted list's and at most 1.6 percent above") {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{100}, std::size_t{20000}}) {
      INFO("seed " << seed << ", " << count << " durations");
      std::vector<std::uint64_t> all = durations(seed, count);
      LatencyHistogram histogram;
      std::uint64_t sum = 0;
      for (const std::uint64_t ns : all) {
        histogram.record(ns);
        sum += ns;
      }
      std::sort(all.begin(), all.end());
      CHECK(histogram.count() == all.size());
      CHECK(histogram.min() == all.front());
      CHECK(histogram.max() == all.back());
      CHECK(histogram.sum() == sum);
      CHECK(histogram.mean() == Approx(static_cast<double>(sum) / static_cast<double>(count)));
      for (const double q : {0.0, 0.001, 0.07, 0.25, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
        const std::uint64_t exact = exact_percentile(all, q);
        const std::uint64_t got = histogram.percentile(q);
        INFO("q = " << q);
        CHECK(got >= exact);
        CHECK(static_cast<double>(got - exact) <= 0.016 * static_cast<double>(exact));
      }
    }
  }
}

TEST_CASE("each duration lies inside its bucket, and buckets tile the range without gap or overlap") {
  std::vector<std::uint64_t> probes;
  for (int power = 0; power < 37; ++power) {
    for (const std::int64_t step : {-1, 0, 1}) {
      probes.push_back((std::uint64_t{1} << power) + static_cast<std::uint64_t>(step));
    }
  }
  for (const std::uint64_t ns : durations(4, 5000)) probes.push_back(ns);
  for (const std::uint64_t ns : probes) {
    LatencyHistogram one;
    one.record(ns);
    int buckets = 0;
    one.for_each_bucket([&](std::uint64_t low, std::uint64_t high, std::uint64_t count) {
      ++buckets;
      INFO(ns << " ns in " << low << ".." << high);
      CHECK(count == 1);
      CHECK(low <= ns);
      CHECK(ns <= high);
      if (ns < LatencyHistogram::kOverflowNs) CHECK((high - low) * 64 <= low);
    });
    CHECK(buckets == 1);
  }

  LatencyHistogram every;
  std::uint64_t next = 0;
  for (std::uint64_t ns = 0; ns < LatencyHistogram::kOverflowNs; ns += 1 + ns / 130) every.record(ns);
  every.record(LatencyHistogram::kOverflowNs);
  bool tiled = true;
  std::uint32_t buckets = 0;
  every.for_each_bucket([&](std::uint64_t low, std::uint64_t high, std::uint64_t) {
    tiled = tiled && low == next;
    next = high + 1;
    ++buckets;
  });
  CHECK(tiled);
  CHECK(buckets == LatencyHistogram::kBuckets);
}

TEST_CASE("a merged histogram equals one that saw everything") {
  LatencyHistogram first;
  LatencyHistogram second;
  LatencyHistogram both;
  for (const std::uint64_t ns : durations(5, 3000)) {
    first.record(ns);
    both.record(ns);
  }
  for (const std::uint64_t ns : durations(6, 500)) {
    second.record(ns);
    both.record(ns);
  }
  first.merge(second);
  first.merge(LatencyHistogram{});
  CHECK(first.count() == both.count());
  CHECK(first.sum() == both.sum());
  CHECK(first.min() == both.min());
  CHECK(first.max() == both.max());
  for (double q = 0.0; q <= 1.0; q += 0.01) CHECK(first.percentile(q) == both.percentile(q));
}

TEST_CASE("a duration that came many times counts as if each had been recorded by itself") {
  LatencyHistogram at_once;
  LatencyHistogram one_by_one;
  std::uint64_t times = 0;  // none at all, the first time
  for (const std::uint64_t ns : durations(7, 40)) {
    at_once.record_many(ns, times);
    for (std::uint64_t i = 0; i < times; ++i) one_by_one.record(ns);
    times = (times + 3) % 11;
    REQUIRE(at_once.count() == one_by_one.count());
    REQUIRE(at_once.sum() == one_by_one.sum());
    REQUIRE(at_once.min() == one_by_one.min());
    REQUIRE(at_once.max() == one_by_one.max());
    for (double q = 0.0; q <= 1.0; q += 0.05) REQUIRE(at_once.percentile(q) == one_by_one.percentile(q));
  }
}

TEST_CASE("a merge takes over the other's minimum and maximum") {
  LatencyHistogram first;
  first.record(50);
  LatencyHistogram second;
  second.record(7);
  second.record(90);
  first.merge(second);
  CHECK(first.min() == 7);
  CHECK(first.max() == 90);
}

TEST_CASE("ranks do not slip by the rounding of q times count") {
  LatencyHistogram histogram;
  for (std::uint64_t ns = 1; ns <= 100; ++ns) histogram.record(ns);
  for (std::uint64_t rank = 1; rank <= 100; ++rank) {
    CHECK(histogram.percentile(static_cast<double>(rank) / 100.0) == rank);
    CHECK(histogram.percentile(static_cast<double>(rank) * 0.01) == rank);
  }
}

TEST_CASE("an empty histogram says zero, and durations beyond the range keep their exact maximum") {
  LatencyHistogram histogram;
  CHECK(histogram.count() == 0);
  CHECK(histogram.min() == 0);
  CHECK(histogram.max() == 0);
  CHECK(histogram.mean() == 0.0);
  CHECK(histogram.percentile(0.5) == 0);
  histogram.record(10);
  histogram.record(LatencyHistogram::kOverflowNs * 3);
  histogram.record(~std::uint64_t{0} / 4);
  CHECK(histogram.max() == ~std::uint64_t{0} / 4);
  CHECK(histogram.percentile(1.0) == ~std::uint64_t{0} / 4);
  CHECK(histogram.percentile(0.3) == 10);
  CHECK(histogram.percentile(-3.0) == 10);
  CHECK(histogram.percentile(7.0) == histogram.max());
  CHECK(histogram.percentile(std::numeric_limits<double>::quiet_NaN()) == 10);
  histogram.clear();
  CHECK(histogram.count() == 0);
  CHECK(histogram.min() == 0);
}

}  // namespace sortie::rt
