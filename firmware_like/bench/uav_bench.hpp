// SPDX-License-Identifier: BSD-3-Clause
// The multirotor's benchmark: a program of its own (sortie-bench-uav, which links the peers) that is found,
// run and shown here.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/json.hpp"
#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// How much to measure.
struct UavBenchOptions {
  std::uint64_t seeds{3};   ///< of noise
  std::uint64_t fleet{40};  ///< vehicles that are drawn
  std::string only;         ///< one part alone
  std::string program;      ///< sortie-bench-uav, if it is not where a build or an installation puts it
  unsigned passes{1};       ///< runs of that program, a process each
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added. Throws BenchRefused with the cure.
Json run_uav_bench(const UavBenchOptions& options);

/// The tables, part by part: ours, theirs, ratio, and the goals.
void print_uav_bench(std::ostream& out, const Json& result, bool colour = false);

/// The same as a Markdown page with its pictures, with `command` as how to get it again.
std::string uav_bench_page(const Json& result, const std::string& command);

/// A picture, the name of its file and the part that it belongs to.
struct UavPicture {
  std::string file;
  std::string group;
  Plot plot;
};

/// What the benchmark asked to draw.
std::vector<UavPicture> uav_pictures(const Json& result);

}  // namespace sortie::firmware
