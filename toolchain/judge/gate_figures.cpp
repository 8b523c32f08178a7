// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "rt/posix/delay_cause.hpp"
#include "toolchain/judge/gate.hpp"

namespace sortie::toolchain {

namespace {

// The larger of both; what is no number stays, and breaks every bound.
double larger(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

double number(std::uint64_t count) { return static_cast<double>(count); }

// Puts figures where they belong: known, or absent with the reason.
class Collector {
 public:
  explicit Collector(const firmware::Results& results) : results_(results) {}

  void add(const std::string& name, double value) { figures.known[name] = value; }
  // A figure of jobs, of which there were none where `count` is 0.
  void add_of(std::uint64_t count, const std::string& name, double value) {
    if (count != 0) return add(name, value);
    figures.absent[name] = "was not measured: no such job ran; run longer";
  }
  // A figure of the live run's clock. `instead`: what the machine here measured of the same, if anything.
  void add_live(std::uint64_t count, const std::string& name, double value, const std::string& instead = {}) {
    if (results_.live.known) return add_of(count, name, value);
    figures.absent[name] =
        "is measured in a live run, and " + results_.live.why_not +
        (instead.empty() ? "" : "; " + instead + " is the figure of the machine that runs this command");
  }
  // A figure that a live run tells at its end.
  void add_told(bool known, const std::string& name, double value) {
    if (!results_.live.known) return add_live(1, name, value);
    if (known) return add(name, value);
    figures.absent[name] =
        "is not known: " + (results_.live.why_no_causes.empty()
                                ? "the live run did not ask for causes (live.attribution) or was refused them"
                                : results_.live.why_no_causes);
  }

  GateFigures figures;

 private:
  const firmware::Results& results_;
};

// What holds for all tasks, groups and pools together, so that a gate need not name each of them.
void add_whole(const firmware::Results& results, Collector& to) {
  double missed = 0;
  std::uint64_t jobs = 0;
  double refused = 0;
  double latest = 0;
  double response = 0;
  double longest = 0;
  double longest_here = 0;
  for (const firmware::LiveTask& task : results.live.tasks) longest = larger(longest, task.max_us);
  for (const firmware::TaskResult& task : results.tasks) longest_here = larger(longest_here, task.max_us);
  for (const firmware::GroupResult& group : results.groups) {
    missed += number(group.missed);
    jobs += group.jobs;
    latest = larger(latest, group.late_max_us);
    response = larger(response, group.response_max_us);
  }
  for (const firmware::PoolResult& pool : results.pools) refused += number(pool.refused);
  to.add("all.missed", missed);
  to.add("all.refused", refused);
  to.add_live(jobs, "all.max_us", longest, "here.max_us");
  to.add_live(jobs, "all.late_max_us", latest);
  to.add_live(jobs, "all.response_max_us", response);
  to.add_of(jobs, "here.max_us", longest_here);
  to.add("here.speed", results.speed);
}

void add_tasks(const firmware::Results& results, Collector& to) {
  const auto times = [](const auto& task, const auto& put) {
    put("p50_us", task.p50_us);
    put("p99_us", task.p99_us);
    put("p999_us", task.p999_us);
    put("max_us", task.max_us);
  };
  for (const firmware::TaskResult& task : results.tasks) {
    const std::string prefix = "tasks." + task.name + ".";
    to.add(prefix + "count", number(task.count));
    to.add(prefix + "missed", number(task.missed));
    firmware::LiveTask live;
    for (const firmware::LiveTask& one : results.live.tasks) {
      if (one.name == task.name) live = one;
    }
    times(live, [&](const std::string& name, double us) {
      to.add_live(live.count, prefix + name, us, "here." + prefix + name);
    });
    times(task,
          [&](const std::string& name, double us) { to.add_of(task.count, "here." + prefix + name, us); });
  }
}

void add_delays(bool known, const std::string& prefix, const firmware::DelayTableResult& table,
                Collector& to) {
  const auto add_fields = [&](const std::string& before, const auto& fields) {
    rt::for_each_scalar(fields, [&](const char* name, int, auto value) {
      to.add_told(known, before + name, static_cast<double>(value));
    });
  };
  add_fields(prefix, table);
  for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
    const std::string name = rt::posix::to_string(static_cast<rt::posix::DelayCause>(i));
    const auto cause = table.causes.find(name);  // what never was a cause is not in the table
    add_fields(prefix + "causes." + name + ".",
               cause == table.causes.end() ? firmware::CauseResult{} : cause->second);
  }
}

void add_groups(const firmware::Results& results, Collector& to) {
  for (const firmware::GroupResult& group : results.groups) {
    const std::string prefix = "groups." + group.name + ".";
    to.add(prefix + "jobs", number(group.jobs));
    to.add(prefix + "missed", number(group.missed));
    to.add(prefix + "skipped", number(group.skipped));
    to.add(prefix + "worst_in_row", number(group.worst_in_row));
    to.add(prefix + "promises_broken", number(group.promises_broken));
    const std::uint64_t timed = group.lateness.size();
    to.add_live(timed, prefix + "late_p50_us", group.late_p50_us);
    to.add_live(timed, prefix + "late_p99_us", group.late_p99_us);
    to.add_live(timed, prefix + "late_p999_us", group.late_p999_us);
    to.add_live(timed, prefix + "late_max_us", group.late_max_us);
    to.add_live(timed, prefix + "response_max_us", group.response_max_us);
    to.add_told(group.wake_known, prefix + "spinning", group.spinning);
    to.add_told(group.wake_known, prefix + "margin_us", group.margin_us);
    to.add_told(group.wake_known, prefix + "stack_bytes", number(group.stack_bytes));
    add_delays(group.delays.known, prefix + "delays.start.", group.delays.start, to);
    add_delays(group.delays.known, prefix + "delays.execution.", group.delays.execution, to);
  }
}

void add_measured(const std::string& prefix, const firmware::ChainFigures& measured, const std::string& why,
                  Collector& to) {
  rt::for_each_scalar(measured, [&](const std::string& name, int, auto value) {
    if (measured.count != 0)
      to.add(prefix + "." + name, static_cast<double>(value));
    else
      to.figures.absent[prefix + "." + name] = why;
  });
}

void add_chains(const firmware::Results& results, Collector& to) {
  for (const firmware::ChainResult& chain : results.chains) {
    const std::string prefix = "chains." + chain.name + ".";
    const std::string nothing =
        "was not measured: no output knew of a sample; run longer, or correct the source";
    to.add(prefix + "reaction_us", chain.reaction_us);
    to.add(prefix + "age_us", chain.age_us);
    to.add(prefix + "reactions_over", number(chain.reactions_over));
    to.add(prefix + "ages_over", number(chain.ages_over));
    to.add(prefix + "unmeasured", number(chain.unmeasured));
    add_measured(prefix + "measured_reaction", chain.reaction, nothing, to);
    add_measured(prefix + "measured_age", chain.age, nothing, to);
    add_measured(prefix + "measured_finished", chain.finished,
                 results.live.known ? nothing : "is measured in a live run, and " + results.live.why_not, to);
    if (chain.reaction.count > 1)
      to.add(prefix + "source_interval_max_us", chain.source_interval_max_us);
    else
      to.figures.absent[prefix + "source_interval_max_us"] = nothing;
  }
}

}  // namespace

GateFigures gate_figures(const firmware::Results& results) {
  Collector to(results);
  for (const auto& [name, value] : results.errors) to.add("errors." + name, value);
  for (const auto& [name, value] : results.counters) {
    if (name == "over_budget") {
      to.add_live(1, "counters." + name, number(results.live.over_budget), "here." + name);
      to.add("here." + name, number(value));
    } else {
      to.add("counters." + name, number(value));
    }
  }
  for (const firmware::PoolResult& pool : results.pools) {
    const std::string prefix = "pools." + pool.name + ".";
    to.add(prefix + "high_water", number(pool.high_water));
    to.add(prefix + "refused", number(pool.refused));
  }
  add_tasks(results, to);
  add_groups(results, to);
  add_chains(results, to);
  add_whole(results, to);
  to.add("ticks", number(results.ticks));
  to.figures.absent["speed"] = "is called here.speed: it is that of the machine that runs this command";
  return std::move(to.figures);
}

}  // namespace sortie::toolchain
