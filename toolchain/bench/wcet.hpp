// SPDX-License-Identifier: BSD-3-Clause
// The worst case of every task, in instructions: a replay under callgrind, counted job by job. The same to
// the instruction each time; what a processor makes of them is not in it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {

/// What to count.
struct WcetOptions {
  std::string log;
  std::string scene;  ///< empty: the profile that stands in the log
  std::vector<std::string> overrides;
  firmware::KeptMapPaths maps;  ///< that the replay begins with
  std::string fault;  ///< "task@tick": 1000 turns of an empty loop there; proves that a gate can fail
};

/// One job of a task.
struct CountedJob {
  std::uint64_t tick{};
  std::uint64_t instructions{};
};

/// One task: its jobs, in order of ticks.
struct WcetTask {
  std::string name;
  std::string group;
  double budget_us{};
  std::vector<CountedJob> jobs;
};

/// All tasks, in order of the table.
struct Wcet {
  std::string scene;
  std::string built_by;  ///< compiler, flags and C library: only counts of the same are comparable
  std::vector<WcetTask> tasks;
};

/// Instructions cannot be counted here; commands end with exit code 4.
class CountRefused : public firmware::PlatformRefused {
 public:
  using firmware::PlatformRefused::PlatformRefused;
};

/// Starts this program again under callgrind and reads what it counts. Throws CountRefused (valgrind or its
/// header missing, with the cure) and InputError with the code of a counted program that failed.
Wcet measure_wcet(const WcetOptions& options);

/// The counted program's side: replays, marks each job, writes which mark is which to `jobs_file`. Throws as
/// replay() does.
void replay_counted(const firmware::VehicleRegistry& vehicles, const WcetOptions& options,
                    const std::string& jobs_file);

}  // namespace sortie::toolchain
