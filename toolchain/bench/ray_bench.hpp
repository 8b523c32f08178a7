// SPDX-License-Identifier: BSD-3-Clause
// The ray scheduler's benchmark: a program of its own (sortie-bench-rays, which holds the published planners)
// that is found, run and shown here.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/scene/json.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// How much to measure.
struct RayBenchOptions {
  int rounds{3};        ///< of what is timed
  int seeds{2};         ///< streets of each kind
  std::string only;     ///< one part alone: curves, units, picture
  std::string program;  ///< sortie-bench-rays, if it is not where a build or an installation puts it
  unsigned passes{1};   ///< runs of that program, a process each
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added. Throws BenchRefused with the cure.
firmware::Json run_ray_bench(const RayBenchOptions& options);

/// The tables, part by part.
void print_ray_bench(std::ostream& out, const firmware::Json& result, bool colour = false);

/// The same as a Markdown page, with `command` as how to get it again.
std::string ray_bench_page(const firmware::Json& result, const std::string& command);

/// A picture and the name of its file.
struct RayPicture {
  std::string file;
  Plot plot;
};

/// Worth over run time, and the chosen rays over the entropy of the map.
std::vector<RayPicture> ray_pictures(const firmware::Json& result);

}  // namespace sortie::toolchain
