// SPDX-License-Identifier: BSD-3-Clause
// The real-time benchmark: a program of its own (sortie-bench-rt, which links the peers) that is found, run
// and shown here.
#pragma once

#include <iosfwd>
#include <string>

#include "firmware_like/json.hpp"
#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// How much to measure.
struct RtBenchOptions {
  int rounds{11};       ///< of each part
  double slice_s{1};    ///< length of one wake-up slice
  int core{-1};         ///< to measure on; -1: the last one
  int load{0};          ///< busy processes beside the wake-up slices
  std::string only;     ///< one part alone: wake, queue, count, mailbox, executive, calls, cause, load
  std::string program;  ///< sortie-bench-rt, if it is not where a build or an installation puts it
  unsigned passes{1};   ///< runs of that program, a process each
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added. Throws BenchRefused with the cure.
Json run_rt_bench(const RtBenchOptions& options);

/// The table, part by part: ours, theirs, ratio, each with its range over the rounds, and the goals.
void print_rt_bench(std::ostream& out, const Json& result, bool colour = false);

/// The same as a Markdown page, with `command` as how to get it again.
std::string rt_bench_page(const Json& result, const std::string& command);

/// Lateness of wake-ups: log count over microseconds, one curve a method, a line at the period.
Plot plot_wake_ups(const Json& result);

}  // namespace sortie::firmware
