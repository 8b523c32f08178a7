// SPDX-License-Identifier: BSD-3-Clause
// Sweeps that belong together: the same knobs over several logs with what each combination gives over all of
// them, or each knob alone.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "toolchain/sweep/sweep_folder.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// A sweep of one log.
struct LogSweep {
  std::string log;
  Sweep sweep;
};

/// One figure over several logs.
struct Spread {
  double mean{};
  double low{};
  double high{};
};

/// One combination of values over all logs that have it and its error.
struct SweepSpread {
  std::vector<std::string> values;
  std::size_t logs{};
  Spread error;          ///< of SweepSet::error, in its unit
  Spread load_us_per_s;  ///< as SweepCell::load_us_per_s
  bool profile_choice{};
  bool on_front{};  ///< by the means
};

/// Sweeps of one log or several.
struct SweepSet {
  std::vector<LogSweep> logs;
  std::string error;                ///< that the spread is of; empty: there is none
  std::vector<SweepSpread> spread;  ///< empty for one log and for each knob alone
  std::vector<std::string> warnings;
};

/// Takes finished sweeps together. To have a spread logs must be swept over the same knobs and judged by the
/// same error; a warning says where the error is another.
SweepSet make_sweep_set(std::vector<LogSweep> logs);

/// What the folders hold of a plan: cells, judged; the numbers of those that no folder has go to `missing`.
/// While any is missing nothing is judged and the set is empty. Throws ProfileError (no such error).
SweepSet gather_sweep(const SweepFolderPlan& plan, const std::vector<std::string>& folders,
                      std::vector<std::size_t>& missing);

/// Table of each log, then of the spread.
void print_sweep_set(std::ostream& out, const SweepSet& set, bool colour = false);
/// One log: the object of its sweep with `log`; several: {logs[], error, spread[]{values{}, logs, error{mean,
/// low, high}, load_us_per_s{}, profile_choice, on_front}, warnings[]}.
firmware::Json to_json(const SweepSet& set);
/// Lines of the spread's table: the head, then one a combination; one that has a mark is longer.
std::vector<std::vector<std::string>> spread_rows(const SweepSet& set);
/// Name of the i-th sweep's CSV and plot, without what stands behind the point.
std::string sweep_file(const SweepSet& set, std::size_t i);
/// Tables and plots of all sweeps as Markdown, with `command` as how to get it again.
std::string sweep_page(const SweepSet& set, const std::string& command);
/// One sweep: sweep.json, sweep.md, sweep.csv and sweep.svg; several: sweep.json, sweep.md, spread.csv where
/// there is one, and sweep-N.csv, sweep-N.svg of each. `object` is what sweep.json says. Throws InputError.
void write_sweep_set(const std::string& folder, const SweepSet& set, const firmware::Json& object);

}  // namespace sortie::toolchain
