// SPDX-License-Identifier: BSD-3-Clause
// The last step of a live run: what came out, for people and for files.
#include <cmath>

#include "firmware_like/live/live_session.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/log/recorded_times.hpp"
#include "firmware_like/log/stream_use.hpp"
#include "firmware_like/runtime/heap_watch.hpp"

namespace sortie::firmware {

namespace {

std::uint64_t microseconds_of(rt::Nanoseconds ns) {
  return static_cast<std::uint64_t>(ns / rt::kNanosecondsPerMicrosecond);
}

// What the clock said of the robot: in simulated time nothing.
void add_live(Results& results, LiveMeasured& live, bool virtual_time) {
  if (virtual_time) {
    results.live.why_not = "this run was in simulated time, where nothing is late; leave out --virtual";
    return;
  }
  results.live.known = true;
  results.live.over_budget = results.counters.at("over_budget");
  for (const TaskResult& task : results.tasks)
    results.live.tasks.push_back(
        {task.name, task.count, task.p50_us, task.p99_us, task.p999_us, task.max_us});
  for (std::size_t i = 0; i < live.groups.size(); ++i) {
    results.groups[i].wake_known = true;
    results.groups[i].spinning = live.groups[i].spinning;
    results.groups[i].margin_us = live.groups[i].margin_us;
    results.groups[i].stack_bytes = live.groups[i].stack_bytes;
    results.groups[i].delays = std::move(live.groups[i].delays);
  }
}

}  // namespace

// What a gate asks for stands in the log, too: for whoever judges it later, elsewhere.
void LiveSession::collect_measured() {
  Results& results = outcome_.results;
  results = collect_results(runtime_, ticks_);
  results.counters.insert(live_.counters.begin(), live_.counters.end());
  if (const HeapWatch heap = heap_watch(); heap.calls != nullptr)
    results.counters["heap_calls"] = heap.calls() - heap_before_;
  add_live(results, live_, options_.virtual_time);
  if (!options_.virtual_time) write_measured(*recorder_, results, executive_.time_of(ticks_), utc_minus_run_);
}

void LiveSession::collect_trajectories() {
  outcome_.estimate = collector_->estimate.poses.take();
  outcome_.located = collector_->located.poses.take();
  outcome_.truth = surroundings_->truth.poses.take();
  outcome_.contacts = surroundings_->truth.contacts.take();
  tidy(outcome_.estimate);
  tidy(outcome_.located);
  tidy(outcome_.truth);
}

LiveRunOutcome LiveSession::collect() {
  collect_trajectories();
  Results& results = outcome_.results;
  chains_->add_to(results);
  outcome_.failures = unused_streams(runtime_, pushed_streams(runtime_), false);
  results.warnings.insert(results.warnings.begin(), outcome_.failures.begin(), outcome_.failures.end());
  if (options_.virtual_time) {
    const std::vector<std::string> exceeded = exceeded_bounds(results);
    outcome_.failures.insert(outcome_.failures.end(), exceeded.begin(), exceeded.end());
  }
  if (!outcome_.stopped.empty()) results.warnings.push_back(outcome_.stopped);
  results.duration_s = static_cast<double>(ticks_) * static_cast<double>(executive_.base_tick_ns()) * 1e-9;
  results.speed = wall_s_ > 0 ? results.duration_s / wall_s_ : 0;
  collect_counters(results);
  collect_traffic(results);
  if (const std::string problem = recorder_->error(); !problem.empty()) warnings_.push_back(problem);
  results.warnings.insert(results.warnings.end(), warnings_.begin(), warnings_.end());
  results.doctor = std::move(health_);
  return std::move(outcome_);
}

// Of the run itself.
void LiveSession::collect_counters(Results& results) {
  const UnitTrial& trial = booted_.trial;
  if (!trial.task.empty()) {
    results.counters["calibration_" + trial.task + "_ps_per_unit"] =
        static_cast<std::uint64_t>(std::llround(1e3 * trial.ns_per_unit));
  }
  for (const ChosenUnits& chosen : booted_.chosen) {
    results.counters["calibration_" + chosen.task + "_units"] = chosen.units;
    if (!chosen.timed)
      results.warnings.push_back("tasks." + chosen.task +
                                 ".units = \"auto\": nothing timed them here; the default was taken, " +
                                 std::to_string(chosen.units));
  }
  results.counters["log_events"] = recorder_->events();
  results.counters["log_bytes"] = recorder_->bytes();
  results.counters["log_lost_jobs"] = recorder_->lost_jobs();
  results.counters["log_lost_samples"] = recorder_->lost_samples();
  if (robot_) robot_->add_counters(results.counters);
  if (!outcome_.contacts.empty())
    results.counters["bench_truth_contacts_dropped"] = surroundings_->truth.contacts_dropped;
}

// What went to the outside and came from there.
void LiveSession::collect_traffic(Results& results) {
  if (telemetry_) {
    results.counters["lcm_published"] = telemetry_->counters().published;
    results.counters["lcm_dropped"] = telemetry_->counters().dropped;
  }
  if (!options_.virtual_time) {  // what telling the outside cost, on ordinary threads
    results.counters["recorder_cpu_us"] = microseconds_of(recorder_->cpu_ns());
    if (telemetry_) results.counters["telemetry_cpu_us"] = microseconds_of(telemetry_->cpu_ns());
  }
  parameters_->add_counters(results.counters);
  if (!link_) return;
  link_->add_counters(results.counters);
  const std::vector<std::string> silences = link_->warnings();
  warnings_.insert(warnings_.end(), silences.begin(), silences.end());
}

}  // namespace sortie::firmware
