// SPDX-License-Identifier: BSD-3-Clause
// Cells of a sweep in processes of their own, several at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "toolchain/sweep/sweep_folder.hpp"

namespace sortie::toolchain {

/// Which cells, and how.
struct SweepJobsOptions {
  std::string folder;              ///< with its plan.json
  std::size_t jobs{1};             ///< processes at a time
  std::vector<std::size_t> cells;  ///< those that the folder holds already are not run again
  /// After each cell: cells done and to do, the cell, its seconds, seconds that are left (by the mean so
  /// far).
  std::function<void(std::size_t done, std::size_t all, std::size_t cell, double took_s, double left_s)>
      on_cell;
};

/// How it went.
struct SweepJobsEnd {
  std::size_t taken{};              ///< cells that were there already
  std::size_t stale{};              ///< cells that were there, of another program, log or setting: run again
  std::vector<std::size_t> failed;  ///< cells whose process failed; it said why on stderr
  int signal{};                     ///< that stopped the sweep; 0: none
};

/// Runs `this program bench --cell N --out FOLDER` for each cell. SIGINT, SIGTERM and SIGHUP end the
/// processes and the sweep; what is done stays. Throws std::runtime_error where no process can be started.
SweepJobsEnd run_sweep_jobs(const SweepFolderPlan& plan, const SweepJobsOptions& options);

/// What such a process does: runs one cell of FOLDER/plan.json and writes its file. Throws InputError where
/// log or program are not those of the plan, and as replay() does.
void run_sweep_cell(const std::string& folder, std::size_t cell, const firmware::VehicleRegistry& vehicles);

/// Cells of shard `i` of `n`, 1 <= i <= n: every n-th, so that long and short ones mix.
std::vector<std::size_t> shard_cells(std::size_t cells, std::size_t i, std::size_t n);

}  // namespace sortie::toolchain
