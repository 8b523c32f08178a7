// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench knobs`: every knob of the algorithms that a scene has, one at a time, over one recording.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "toolchain/bench/knob_table.hpp"
#include "toolchain/report/svg.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// One recording and how it is judged.
struct KnobSet {
  std::string name;
  std::string log;
  std::string scene;                   ///< of an imported log; otherwise that of the drive
  std::vector<std::string> overrides;  ///< of every replay
  EvaluationOptions evaluation;
};

/// One knob, swept alone.
struct KnobSweep {
  KnobTrial trial;
  Sweep sweep;
};

/// Sweeps all knobs of a set, `repeat` replays a cell. Throws what run_sweep() throws.
std::vector<KnobSweep> sweep_knobs(const KnobSet& set, const firmware::VehicleRegistry& vehicles,
                                   std::uint32_t repeat, const std::function<void(double share)>& progress);

/// A row a cell: {set, part, knob, value, error, errors{}, load_us_per_s, p50_us, p99_us, max_us,
/// memory_bytes, front, profile}. Names and values are texts.
firmware::Json to_json(const std::string& set, const std::vector<KnobSweep>& sweeps);

/// The same as Markdown, each knob with unit, range and meaning; and as text.
std::string knob_table(const std::vector<KnobSweep>& sweeps);
void print_knobs(std::ostream& out, const std::string& set, const std::vector<KnobSweep>& sweeps);

/// Error and run time of each cell as shares of what the profile's own choice has. Cells that differ by less
/// than a fiftieth in error are dots without a name. Without the map, whose error is of another kind.
Plot plot_knobs(const std::string& set, const std::vector<KnobSweep>& sweeps);

}  // namespace sortie::toolchain
