// SPDX-License-Identifier: BSD-3-Clause
// A sweep for a cluster: the array script, and the line that runs again what is missing.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sortie::toolchain {

/// A script for a sweep of `cells` cells in FOLDER/plan.json. Paths are absolute: a task runs on another
/// machine that sees the same files.
struct ArrayScript {
  std::string program;
  std::string folder;
  std::size_t cells{};

  /// Tasks of the array: one a cell up to what Slurm allows without being told (1000); then task i runs the
  /// cells i, i + tasks, ...
  std::size_t tasks() const;
  /// The script: for sbatch; started without it, it tells what to do and ends with 2.
  std::string text() const;
};

/// Cells as an array writes them: "0,3-7,9". Precondition: sorted.
std::string cell_list(const std::vector<std::size_t>& cells);

/// Remembers the script beside the plan, for resubmitting. Throws InputError.
void remember_script(const std::string& folder, const std::string& script_path, const ArrayScript& script);

/// How to run the missing cells of a folder again: words of the command, `sbatch --array=LIST SCRIPT` where a
/// script was made for it, else `PROGRAM bench --cell LIST --out FOLDER`.
std::vector<std::string> resubmit_command(const std::string& program, const std::string& folder,
                                          const std::vector<std::size_t>& missing);

}  // namespace sortie::toolchain
