// SPDX-License-Identifier: BSD-3-Clause
// Every part's benchmark one after another, into one folder with one page.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// One part: `bench ARGUMENTS --out FOLDER/NAME` writes FOLDER/NAME/JSON_FILE.
struct BenchPart {
  std::string name;
  std::vector<std::string> arguments;
  std::string json_file;
  bool has_passes{};  ///< takes --passes
};

/// All parts, in the order in which they run: the short ones first.
const std::vector<BenchPart>& bench_parts();

/// What to run.
struct BenchAllOptions {
  std::string folder;
  std::vector<std::string> only;  ///< names of parts; empty: all
  unsigned passes{2};             ///< processes a part whose figures have peers
  /// Before a part: its number from 0, of how many, its name, seconds since the start.
  std::function<void(std::size_t part, std::size_t parts, const std::string& name, double since_s)> on_part;
};

/// Runs the parts with this program, a process each; what they print is left out, the words go to stderr. A
/// part that cannot run (program not built) is named with its exit code. Gives {machine, compiler, doctor,
/// load_before, load_after, took_s, parts[]{name, command, exit_code, took_s, load_before, goals, met,
/// missed[], skipped[]}}. Throws InputError.
firmware::Json run_bench_all(const BenchAllOptions& options);

/// The page of a folder, Markdown: machine, load, goals met and missed of each part with links.
std::string bench_all_page(const firmware::Json& index, const std::string& command);

}  // namespace sortie::toolchain
