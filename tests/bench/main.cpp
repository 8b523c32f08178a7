// SPDX-License-Identifier: BSD-3-Clause
// Runs all benchmarks, interleaved so that a slow moment of the machine meets a benchmark and its peers
// alike, and prints the table of ratios. Takes Google Benchmark's own options, e.g. --benchmark_filter=ring.
#include <benchmark/benchmark.h>

#include <future>
#include <iostream>
#include <thread>
#include <vector>

#include "tests/bench/ratio_table.hpp"

int main(int argc, char** argv) {
  static char name[] = "sortie_bench";
  static char repetitions[] = "--benchmark_repetitions=101";
  static char interleave[] = "--benchmark_enable_random_interleaving=true";
  static char time[] = "--benchmark_min_time=0.002";
  std::vector<char*> arguments{argc > 0 ? argv[0] : name, repetitions, interleave, time};
  for (int i = 1; i < argc; ++i) arguments.push_back(argv[i]);  // later ones win
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  // The C library takes its locks without atomic operations while a process has one thread: no robot's has.
  std::promise<void> end;
  std::thread other([waits = end.get_future()] { waits.wait(); });
  sortie::bench::RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  end.set_value();
  other.join();
  std::cerr << "\n";
  reporter.print(std::cout);
  return reporter.failed() ? 1 : 0;
}
