// SPDX-License-Identifier: BSD-3-Clause
#include "rt/declared_table.hpp"

namespace sortie::rt {

ScheduleTable declared_table(const Executive& executive) {
  ScheduleTable table;
  table.base_tick_ns = executive.base_tick_ns();
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    const Group& group = executive.group(i);
    DeclaredGroup declared;
    declared.timing = group.timing;
    declared.core = group.spec.core;
    // Both hold as many as an executive does.
    for (const TaskBase* task : group.tasks) {
      static_cast<void>(declared.tasks.push_back(
          {std::uint64_t{task->budget_us()} * kNanosecondsPerMicrosecond, task->spec().criticality}));
    }
    static_cast<void>(table.groups.push_back(declared));
  }
  return table;
}

}  // namespace sortie::rt
