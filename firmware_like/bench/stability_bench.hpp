// SPDX-License-Identifier: BSD-3-Clause
// The stiff and extreme cases: a program of its own (sortie-bench-stability) that is found, run and shown
// here.
#pragma once

#include <iosfwd>
#include <string>

#include "firmware_like/json.hpp"

namespace sortie::firmware {

/// What to run.
struct StabilityBenchOptions {
  std::string only;     ///< cases of one part alone: rt, drivers, estimators, mapping, planner or hil
  std::string program;  ///< sortie-bench-stability, if it is not where a build or an installation puts it
};

/// Runs the cases (their names go to stderr) and returns the program's object, with machine, compiler and the
/// doctor's verdict added. Throws BenchRefused with the cure.
Json run_stability_bench(const StabilityBenchOptions& options);

/// True when every case has ours within its bound and the naive method outside.
bool is_stable(const Json& result);

/// One line a case: bound, ours, naive, verdict.
void print_stability_bench(std::ostream& out, const Json& result);

/// The same as a Markdown page, with `command` as how to get it again.
std::string stability_bench_page(const Json& result, const std::string& command);

}  // namespace sortie::firmware
