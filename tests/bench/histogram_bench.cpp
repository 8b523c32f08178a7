// SPDX-License-Identifier: BSD-3-Clause
// Counting a duration in the histogram, and asking it for a quantile, beside keeping all samples.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/histogram.hpp"

namespace {

using namespace sortie::rt;

std::vector<std::uint64_t> durations() {
  std::vector<std::uint64_t> values;
  std::uint64_t state = 1;
  for (int i = 0; i < 1024; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    values.push_back((state >> 40) % (1u << (10 + i % 14)));
  }
  return values;
}

void histogram_sortie(benchmark::State& state) {
  const auto histogram = std::make_unique<LatencyHistogram>();
  const std::vector<std::uint64_t> values = durations();
  for (auto _ : state) {
    for (const std::uint64_t ns : values) histogram->record(ns);
    benchmark::ClobberMemory();
  }
  state.counters["ops"] = static_cast<double>(values.size());
}
BENCHMARK(histogram_sortie)->Name("histogram_record/sortie");

void histogram_vector(benchmark::State& state) {
  const std::vector<std::uint64_t> values = durations();
  std::vector<std::uint64_t> kept;
  for (auto _ : state) {
    kept.clear();  // keeps its memory: the peer at its best, without growth
    for (const std::uint64_t ns : values) kept.push_back(ns);
    benchmark::DoNotOptimize(kept.data());
    benchmark::ClobberMemory();
  }
  state.counters["ops"] = static_cast<double>(values.size());
}
BENCHMARK(histogram_vector)->Name("histogram_record/std::vector of all samples");

void histogram_sorted(benchmark::State& state) {
  const std::vector<std::uint64_t> values = durations();
  for (auto _ : state) {
    std::vector<std::uint64_t> kept = values;
    std::nth_element(kept.begin(), kept.begin() + 1013, kept.end());
    benchmark::DoNotOptimize(kept[1013]);
  }
}
BENCHMARK(histogram_sorted)->Name("histogram_p99/std::nth_element of 1024");

void histogram_percentile(benchmark::State& state) {
  const auto histogram = std::make_unique<LatencyHistogram>();
  for (const std::uint64_t ns : durations()) histogram->record(ns);
  for (auto _ : state) benchmark::DoNotOptimize(histogram->percentile(0.99));
}
BENCHMARK(histogram_percentile)->Name("histogram_p99/sortie");

}  // namespace
