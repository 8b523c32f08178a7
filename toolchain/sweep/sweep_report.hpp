// SPDX-License-Identifier: BSD-3-Clause
// A sweep for people and for programs: table, JSON, CSV and plot.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "toolchain/report/html.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::firmware {
class Json;
}  // namespace sortie::firmware

namespace sortie::toolchain {

/// One line a cell: values, errors, load, times, memory; "*" on the Pareto front, "<" the profile's choice.
void print_sweep(std::ostream& out, const Sweep& sweep, bool colour = false);

/// What was measured of a cell: {errors{}, digest, voxels, voxels_refused, memory_bytes, load_us_per_s,
/// instructions_per_s, tasks[]{name, n, p50_us, p99_us, max_us}}. What is not finite becomes null.
firmware::Json figures_of(const SweepCell& cell);

/// {scene, knobs[], tasks[], error, cost, repeat, duration_s, cells[]{values{}, profile_choice, on_front
/// and the cell's figures}, machine, compiler, warnings[]}. Instructions that were not counted are null.
firmware::Json to_json(const Sweep& sweep);

/// One row a cell, one column a figure; what a cell does not have is an empty field.
void write_sweep_csv(std::ostream& out, const Sweep& sweep);

/// Error over load, each cell named by its values, the front joined, the profile's choice marked. Without an
/// error: the memory of the runtime over load.
Plot plot_sweep(const Sweep& sweep);

/// Plot and figures for a page.
SweepFigures sweep_figures(const Sweep& sweep);

/// "0.1" for one value, "0.1, 25" for two.
std::string listed(const std::vector<std::string>& values);
/// "*" on the front, "<" the profile's choice, or both.
std::string sweep_marks(bool on_front, bool profile_choice);
/// True where any cell has its instructions counted.
bool counts_instructions(const Sweep& sweep);

/// Texts of a line, a column each.
using TextRow = std::vector<std::string>;
/// Lines below each other, each column as wide as it must be; the first says how many there are. What a line
/// has beyond them is its mark; with `colour` that of the profile's choice is bold.
void print_columns(std::ostream& out, const std::vector<TextRow>& rows, bool colour = false);

}  // namespace sortie::toolchain
