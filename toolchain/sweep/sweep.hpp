// SPDX-License-Identifier: BSD-3-Clause
// Error against run time: one log, replayed once for every combination of a profile's knobs.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/log/replay.hpp"
#include "rt/describe.hpp"
#include "toolchain/judge/evaluate.hpp"

namespace sortie::toolchain {

struct MapVolume;

/// One key of a profile and the values it takes, as TOML text each.
struct SweepKnob {
  std::string key;
  std::vector<std::string> values;
};

/// Reads "key=v1,v2,v3". Commas in brackets and quotes belong to the value. Blanks around values are dropped.
/// Throws ProfileError (exit code 2) with a cure when there is no key, no value, an empty or a repeated
/// value.
SweepKnob parse_knob(const std::string& text);

/// Reads all knobs; a key that is given twice is a ProfileError, too, and so are more than `most_cells`
/// cells.
std::vector<SweepKnob> parse_knobs(const std::vector<std::string>& texts, std::size_t most_cells = 4096);

/// Every combination, one value a knob each, in the order of nested loops: the first knob turns slowest.
std::vector<std::vector<std::string>> span_grid(const std::vector<SweepKnob>& knobs);

/// True if `value` is what the profile says anyway: the same number, or the same text.
bool same_value(const std::string& value, const std::string& other);

/// What to sweep.
struct SweepOptions {
  firmware::ReplayOptions replay;  ///< scene, overrides of every cell
  EvaluationOptions evaluation;
  std::vector<SweepKnob> knobs;    ///< that span the grid
  bool each_knob{};                ///< instead: each knob of the scene's algorithms alone; see sweeps_of()
  std::vector<std::string> tasks;  ///< whose run time counts; empty: those that the knobs belong to
  std::string error;               ///< which error counts; empty: chosen by knob and by what the truth allows
  std::uint32_t repeat{1};         ///< replays of every cell
  bool instructions{};             ///< count them under callgrind, once a cell
  std::function<void(double share)> progress;
};

/// Run time of one task over all repetitions of a cell.
struct SweepTiming {
  std::string task;
  std::uint64_t n{};  ///< jobs, all repetitions together
  double p50_us{};
  double p99_us{};
  double max_us{};
  SORTIE_FIELDS(n, p50_us, p99_us, max_us)
};

/// One combination of values.
struct SweepCell {
  std::vector<std::string> values;  ///< one a knob
  bool profile_choice{};            ///< what the profile says by itself
  bool on_front{};  ///< no other is as cheap (within 5 %) and better (by 0.1 %), or as good and cheaper
  std::map<std::string, double> errors;
  std::string digest;
  std::uint64_t voxels{};
  std::uint64_t voxels_refused{};  ///< points that found the pool full
  std::uint64_t memory_bytes{};    ///< of the whole runtime
  /// Of the tasks that count, per second of the robot's time; the same to the instruction each time. 0: not
  /// counted.
  double instructions_per_s{};
  /// Run time of the tasks that count per second of the robot's time, us/s. Every job counts with the
  /// shortest of its repetitions: they repeat the same work, so the rest was the machine. `timing` tells all,
  /// raw.
  double load_us_per_s{};
  std::vector<SweepTiming> timing;
  SORTIE_FIELDS(digest, voxels, voxels_refused, memory_bytes, load_us_per_s, instructions_per_s)
};

/// A sweep and all its figures.
struct Sweep {
  std::string scene;
  std::vector<std::string> keys;   ///< of the knobs, in order
  std::vector<std::string> tasks;  ///< whose run time counts
  std::string error;  ///< key in `errors` of the front; empty: no cell has an error. Before the cells
                      ///< are judged: the one that was asked for
  std::uint32_t repeat{};
  double duration_s{};  ///< of the log
  std::vector<SweepCell> cells;
  std::vector<std::string> warnings;
};

/// Replays `log` for every cell, `repeat` times each, all cells once before any a second time, so that a slow
/// minute of the machine meets all of them. The profile's own choice is added where the grid does not hold
/// it. All cells are built before the first one runs: a bad value shows at once. Throws ProfileError
/// (unknown key, value out of range, unknown task or error) and InputError; std::runtime_error when two
/// repetitions of a cell differ in their digest.
Sweep run_sweep(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                const SweepOptions& options);

/// What the cells of a sweep are worth: `maps`, one a cell, against the finest one, the error that counts,
/// the Pareto front. Where the sweep does not say which error counts, it is chosen by knob and by what the
/// truth allows. Throws ProfileError when no cell has the error that it says.
void judge_sweep(const std::vector<std::optional<MapVolume>>& maps, Sweep& sweep);

}  // namespace sortie::toolchain
