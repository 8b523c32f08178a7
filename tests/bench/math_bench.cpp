// SPDX-License-Identifier: BSD-3-Clause
// The repeatable elementary functions against the C library's, over arguments as a robot has them.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include "rt/math.hpp"

namespace {

constexpr std::size_t kArguments = 512;

template <class F>
void run(benchmark::State& state, double low, double high, F function) {
  std::mt19937 random(1);
  std::array<double, kArguments> x{};
  for (double& value : x) value = low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  for (auto _ : state) {
    double sum = 0;
    for (std::size_t i = 0; i < kArguments; ++i) sum += function(x[i], x[(i + 1) % kArguments]);
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ops"] = static_cast<double>(kArguments);
}

template <class Own, class Libm>
void add(const char* name, double low, double high, Own own, Libm libm) {
  const std::string group = std::string("math_") + name;
  benchmark::RegisterBenchmark((group + "/sortie").c_str(),
                               [=](benchmark::State& state) { run(state, low, high, own); });
  benchmark::RegisterBenchmark((group + "/C library").c_str(),
                               [=](benchmark::State& state) { run(state, low, high, libm); });
}

const bool kAdded = [] {
  namespace rt = sortie::rt;
  add(
      "sin", -7, 7, [](double x, double) { return rt::sin(x); },
      [](double x, double) { return std::sin(x); });
  add(
      "cos", -7, 7, [](double x, double) { return rt::cos(x); },
      [](double x, double) { return std::cos(x); });
  add(
      "sincos", -7, 7,
      [](double x, double) {
        const rt::SinCos both = rt::sincos(x);
        return both.sin + both.cos;
      },
      [](double x, double) { return std::sin(x) + std::cos(x); });
  add(
      "atan2", -5, 5, [](double x, double y) { return rt::atan2(x, y); },
      [](double x, double y) { return std::atan2(x, y); });
  add(
      "asin", -1, 1, [](double x, double) { return rt::asin(x); },
      [](double x, double) { return std::asin(x); });
  add(
      "exp", -20, 20, [](double x, double) { return rt::exp(x); },
      [](double x, double) { return std::exp(x); });
  add(
      "log", 1e-3, 1e3, [](double x, double) { return rt::log(x); },
      [](double x, double) { return std::log(x); });
  return true;
}();

}  // namespace
