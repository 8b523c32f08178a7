// SPDX-License-Identifier: BSD-3-Clause
// The plant's benchmark: a program of its own (sortie-bench-plant, which links ODE) that is found, run and
// shown here.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/json.hpp"
#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// How much to measure.
struct PlantBenchOptions {
  int rounds{5};        ///< of what is timed
  std::string only;     ///< one part alone: speed, count, metrics, belt, steps, depth, pictures
  std::string scene;    ///< one scene alone
  std::string program;  ///< sortie-bench-plant, if it is not where a build or an installation puts it
  unsigned passes{1};   ///< runs of that program, a process each
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added. Throws BenchRefused with the cure.
Json run_plant_bench(const PlantBenchOptions& options);

/// The tables, part by part: ours, theirs, ratio, and the goals.
void print_plant_bench(std::ostream& out, const Json& result, bool colour = false);

/// The same as a Markdown page, with `command` as how to get it again.
std::string plant_bench_page(const Json& result, const std::string& command);

/// A picture and the name of its file.
struct PlantPicture {
  std::string file;
  Plot plot;
};

/// What was measured as pictures: error over run time, and a side view of each drive over obstacles.
std::vector<PlantPicture> plant_pictures(const Json& result);

}  // namespace sortie::firmware
