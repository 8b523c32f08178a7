// SPDX-License-Identifier: BSD-3-Clause
// How many processors there are for this process. Not how many the machine has: an affinity mask (taskset, a
// cpuset, isolcpus) or a quota of its control group may leave fewer.
#pragma once

#include <string_view>
#include <vector>

namespace sortie::rt::posix {

/// Processors that a thread which is not pinned may use.
struct Processors {
  double count{1};         ///< so many threads can run at once; not whole where a quota says so; above 0
  std::vector<int> cores;  ///< which, 0-based, ascending; empty: not known

  /// True when unpinned threads may come to `core`.
  bool has(int core) const;
};

/// Those of the calling thread's affinity mask; at least one. `quota_binds`: no more than the control group's
/// quota (cgroup 2 cpu.max, cgroup 1 cpu.cfs_quota_us), which holds for ordinary threads and not for
/// SCHED_FIFO. Reads some small files: set-up only.
Processors usable_processors(bool quota_binds);

/// Processors that the text of a cpu.max grants ("150000 100000": 1.5), or 0: no limit, or not readable.
double processors_of_quota(std::string_view cpu_max) noexcept;

}  // namespace sortie::rt::posix
