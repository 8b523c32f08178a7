// SPDX-License-Identifier: BSD-3-Clause
// The local map's benchmark: a program of its own (sortie-bench-mapping, which links PCL where it is there)
// that is found, run and shown here.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/json.hpp"
#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// How much to measure.
struct MappingBenchOptions {
  int stride{2};        ///< every n-th point of the recorded scans
  int every{10};        ///< scans between two looks at the peer
  bool count{};         ///< also instructions of each step: minutes
  std::string only;     ///< one part alone: peers, insertion, normals or sweep
  std::string stream;   ///< one stream of the sweep alone: walk, dense or hall
  std::string file;     ///< another recorded drive
  std::string program;  ///< sortie-bench-mapping, if it is not where a build or an installation puts it
  unsigned passes{1};   ///< runs of that program, a process each
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added, and `front` in each cell of the sweep. Throws BenchRefused with the cure.
Json run_mapping_bench(const MappingBenchOptions& options);

/// The goals in one table, then all parts.
void print_mapping_bench(std::ostream& out, const Json& result, bool colour = false);

/// The same as a Markdown page, with `command` as how to get it again.
std::string mapping_bench_page(const Json& result, const std::string& command);

/// A picture and the name of its file.
struct MappingPicture {
  std::string file;
  Plot plot;
};

/// Error over run time of each stream, and the mapped places coloured by segment.
std::vector<MappingPicture> mapping_pictures(const Json& result);

}  // namespace sortie::firmware
