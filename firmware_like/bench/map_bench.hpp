// SPDX-License-Identifier: BSD-3-Clause
// The local map's benchmark: a program of its own (sortie-bench-mapping, which holds PCL and the batch) that
// is found, run and shown here.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware_like/report/svg.hpp"

namespace sortie::firmware {

/// How much to measure.
struct MapBenchOptions {
  std::string log;        ///< recorded scans (.rls); empty: those of the tests
  int every{10};          ///< scans between two looks at PCL
  bool count{};           ///< also the instructions of each step (needs valgrind; takes minutes)
  std::uint64_t seed{1};  ///< of the simulated hall
  std::string only;       ///< one part alone: peers, knobs
  std::string program;    ///< sortie-bench-mapping, if it is not where a build or an installation puts it
};

/// Runs the benchmark (its progress goes to stderr) and returns its object, with machine, compiler and the
/// doctor's verdict added, and each row of the knobs marked. Throws BenchRefused with the cure.
nlohmann::ordered_json run_map_bench(const MapBenchOptions& options);

/// Says of each row whether it lies on the Pareto front of its group (median run time against error), and
/// which error was judged: that against the faces of the world where they are known, else that against the
/// finest voxels. Rows of rejected points (a full pool) are marked, too.
void mark_map_rows(nlohmann::ordered_json& result);

/// The tables, part by part.
void print_map_bench(std::ostream& out, const nlohmann::ordered_json& result, bool colour = false);

/// The same as a Markdown page, with `command` as how to get it again.
std::string map_bench_page(const nlohmann::ordered_json& result, const std::string& command);

/// A picture and the name of its file.
struct MapPicture {
  std::string file;
  Plot plot;
};

/// Error over run time, a picture a group of rows.
std::vector<MapPicture> map_pictures(const nlohmann::ordered_json& result);

}  // namespace sortie::firmware
