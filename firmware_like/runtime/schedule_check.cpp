// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/schedule_check.hpp"

#include <limits>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

double us(std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; }
std::string ms(std::uint64_t ns) { return format_short(static_cast<double>(ns) * 1e-6) + " ms"; }

// Words about the findings of one table.
class Speaker {
 public:
  Speaker(const ScheduleCheck& check, const rt::Executive& executive)
      : check_(check), executive_(executive) {}

  std::string words(const rt::Finding& finding) const {
    switch (finding.kind) {
      case rt::FindingKind::overload:
        return load(finding.core) + ", more than all of it";
      case rt::FindingKind::late:
        return late(finding.a);
      case rt::FindingKind::nearly_full:
        return load(finding.core) +
               "; above 90 % the kernel itself may take real-time threads off a processor for 50 ms";
      case rt::FindingKind::not_harmonic:
        return "not harmonic: neither the period of " + name(finding.a) + " (" + period(finding.a) +
               ") nor that of " + name(finding.b) + " (" + period(finding.b) +
               ") divides the other, so they meet in ever different ways";
      case rt::FindingKind::long_hyperperiod:
        return "the releases repeat too late to be played one by one: responses are bounded for any phases, "
               "and phases are chosen from the first releases";
      case rt::FindingKind::one_processor:
        return "groups without a core are analysed as if they shared one processor with all others; several "
               "make it better, never worse";
    }
    return {};
  }

  // What can be done about a late group.
  std::string cures(std::uint32_t group) const {
    std::string tasks;
    for (const rt::TaskBase* task : executive_.group(group).tasks)
      tasks += (tasks.empty() ? "tasks." : ", tasks.") + std::string(task->name()) + ".budget_us";
    return "give it a longer period (groups." + name(group) + ".rate_hz) or deadline, smaller budgets (" +
           tasks + "), or a core of its own (groups." + name(group) +
           ".core); schedule.accept_overload = true runs it all the same";
  }

  std::string late(std::uint32_t group) const {
    const rt::ResponseBound worst = check_.report.groups[group].worst();
    return "group " + name(group) + " can be done " +
           (worst.known ? ms(worst.ns) + " after its release" : std::string("ever later after its release")) +
           ", but its deadline is " + ms(check_.report.groups[group].deadline_ns);
  }

 private:
  std::string name(std::uint32_t group) const { return executive_.group(group).spec.name; }
  std::string period(std::uint32_t group) const {
    return ms(std::uint64_t{check_.table.groups[group].timing.period} *
              static_cast<std::uint64_t>(check_.table.base_tick_ns));
  }
  std::string load(int core) const {
    const rt::GroupSet here = rt::groups_on(check_.table, core);
    std::string names;
    for (std::uint32_t i = 0; i < check_.table.groups.size(); ++i) {
      if (((here >> i) & 1u) != 0) names += (names.empty() ? "" : ", ") + name(i);
    }
    return (core < 0 ? std::string("a processor") : "processor " + std::to_string(core)) + " is asked for " +
           format_fixed(100 * rt::utilisation(check_.table, here), 1) + " % of its time by " + names;
  }

  const ScheduleCheck& check_;
  const rt::Executive& executive_;
};

double bounded_us(const rt::ResponseBound& bound) {
  return bound.known ? us(bound.ns) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

ScheduleCheck check_schedule(Profile& profile, const rt::Executive& executive) {
  const bool accept = profile.flag("schedule.accept_overload", false,
                                   "run a table that by its declared budgets cannot be on time");
  ScheduleCheck check;
  check.table = rt::declared_table(executive);
  check.report = rt::analyse(check.table);
  const Speaker speaker(check, executive);
  for (const rt::Finding& finding : check.report.findings) {
    if (finding.kind == rt::FindingKind::late && !accept) {
      std::string why = speaker.late(finding.a);
      if (const rt::Finding& worst = check.report.findings[0]; worst.kind == rt::FindingKind::overload)
        why += " (" + speaker.words(worst) + ")";
      profile.fail("groups." + std::string(executive.group(finding.a).spec.name) + ".rate_hz",
                   why + ": " + speaker.cures(finding.a));
    }
    if (finding.kind == rt::FindingKind::late || finding.kind == rt::FindingKind::overload ||
        finding.kind == rt::FindingKind::nearly_full)
      check.warnings.push_back("schedule: " + speaker.words(finding));
  }
  return check;
}

ScheduleResult schedule_result(const ScheduleCheck& check, const rt::Executive& executive) {
  const Speaker speaker(check, executive);
  const double tick_us = static_cast<double>(check.table.base_tick_ns) * 1e-3;
  ScheduleResult result;
  result.base_tick_us = tick_us;
  result.hyperperiod_ticks = check.report.hyperperiod_ticks;
  result.harmonic = check.report.harmonic;
  result.schedulable = check.report.schedulable;
  for (std::uint32_t i = 0; i < check.report.groups.size(); ++i) {
    const rt::GroupReport& group = check.report.groups[i];
    const rt::GroupTiming& timing = check.table.groups[i].timing;
    result.groups.push_back({executive.group(i).spec.name, timing.period * tick_us, timing.phase * tick_us,
                             timing.deadline * tick_us, check.table.groups[i].core, group.priority,
                             group.utilisation, us(group.budget_ns), bounded_us(group.worst()),
                             bounded_us(group.any_phase), group.fits});
  }
  for (const rt::CoreReport& core : check.report.cores) {
    result.cores.push_back({core.core,
                            {core.utilisation, core.utilisation + rt::kLevels},
                            us(core.tick.waiting_ns),
                            us(core.tick.busy_ns)});
  }
  for (const rt::Finding& finding : check.report.findings) result.findings.push_back(speaker.words(finding));
  return result;
}

}  // namespace sortie::firmware
