// SPDX-License-Identifier: BSD-3-Clause
#include "rt/schedule_report.hpp"

namespace sortie::rt {

namespace {

void say(ScheduleReport& report, const Finding& finding) {
  static_cast<void>(report.findings.push_back(finding));  // there is room for all that can be said
}

GroupReport judge(const ScheduleTable& table, std::uint32_t index) {
  const DeclaredGroup& group = table.groups[index];
  GroupReport report;
  for (std::uint32_t other = 0; other < table.groups.size(); ++other) {
    if (runs_before(table, other, index)) ++report.priority;
  }
  report.utilisation = utilisation(table, GroupSet{1} << index);
  report.budget_ns = group.budget_ns();
  report.deadline_ns = group.timing.deadline * static_cast<std::uint64_t>(table.base_tick_ns);
  report.any_phase = response_any_phase(table, index);
  report.with_phases = response_with_phases(table, index);
  report.fits = report.worst().known && report.worst().ns <= report.deadline_ns;
  return report;
}

}  // namespace

ScheduleReport analyse(const ScheduleTable& table) {
  ScheduleReport report;
  const GroupSet all = all_groups(table);
  report.hyperperiod_ticks = hyperperiod(table, all);
  for (const int core : cores_of(table)) {
    CoreReport load;
    load.core = core;
    const GroupSet here = groups_on(table, core);
    for (std::uint8_t level = 0; level < kLevels; ++level)
      load.utilisation[level] = utilisation(table, here, level);
    load.tick = worst_tick(table, here);
    static_cast<void>(report.cores.push_back(load));  // at most one a group
    if (overloads(table, here)) say(report, {FindingKind::overload, 0, 0, core});
  }
  bool played = true;
  for (std::uint32_t i = 0; i < table.groups.size(); ++i) {
    const GroupReport group = judge(table, i);
    static_cast<void>(report.groups.push_back(group));  // as many as there are
    if (!group.fits) say(report, {FindingKind::late, i, 0, table.groups[i].core});
    report.schedulable = report.schedulable && group.fits;
    played = played && (group.with_phases.known || !group.fits);
  }
  for (const CoreReport& load : report.cores) {
    if (load.utilisation[0] > kMostUtilisation && !overloads(table, groups_on(table, load.core)))
      say(report, {FindingKind::nearly_full, 0, 0, load.core});
  }
  const OddPair odd = not_harmonic(table);
  report.harmonic = !odd.found;
  if (odd.found) say(report, {FindingKind::not_harmonic, odd.a, odd.b, -1});
  if (report.hyperperiod_ticks == 0 || !played) say(report, {FindingKind::long_hyperperiod, 0, 0, -1});
  bool shared = false;
  for (const DeclaredGroup& group : table.groups) shared = shared || group.core < 0;
  if (shared && table.groups.size() > 1) say(report, {FindingKind::one_processor, 0, 0, -1});
  return report;
}

}  // namespace sortie::rt
