// SPDX-License-Identifier: BSD-3-Clause
// Runs an executive on a virtual clock: replay and simulation, as fast as the processor allows.
#pragma once

#include <cstdint>

#include "rt/executive.hpp"

namespace sortie::rt {

/// What happens between the jobs of a virtual run. Calls come from one thread, in tick order.
class JobFeed {
 public:
  virtual ~JobFeed() = default;
  /// Before any job of `tick`: a simulated plant moves here.
  virtual void before_tick(Tick tick) { static_cast<void>(tick); }
  /// Just before job `job` of `group`: push its samples, fill its order. False: this release is left out.
  virtual bool prepare(std::uint32_t group, std::uint64_t job, Tick tick, JobOrder& order) = 0;
};

/// Runs ticks first..last (inclusive) on the calling thread; groups that share a tick run in table order. A
/// job runs to its end at its release; its outputs become visible at its deadline. A few ns a group and tick.
inline void run_virtual(Executive& executive, JobFeed& feed, Tick first, Tick last) {
  for (Tick tick = first; tick <= last; ++tick) {
    feed.before_tick(tick);
    for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
      Group& group = executive.group(index);
      if (!group.timing.releases_at(tick)) continue;
      const std::uint64_t job = group.timing.job_at(tick);
      JobOrder order;
      if (feed.prepare(index, job, tick, order)) {
        static_cast<void>(executive.run_job(index, job, order));  // the verdict stands in the record
      } else {
        ++group.skipped;
        group.misses.note(false);
      }
    }
  }
}

}  // namespace sortie::rt
