// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "drivers/can_socket.hpp"
#include "firmware_like/auto_units.hpp"
#include "firmware_like/chain_watch.hpp"
#include "firmware_like/doctor/run_doctor.hpp"
#include "firmware_like/flight_recorder.hpp"
#include "firmware_like/heap_watch.hpp"
#include "firmware_like/live_threads.hpp"
#include "firmware_like/log_clock.hpp"
#include "firmware_like/owned_part.hpp"
#include "firmware_like/parameter_desk.hpp"
#include "firmware_like/recorded_times.hpp"
#include "firmware_like/stream_use.hpp"
#include "firmware_like/telemetry.hpp"
#include "rt/built_parts.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::firmware {

namespace {

bool is_interrupted(const LiveRunOptions& options) {
  return options.interrupted != nullptr && options.interrupted->load();
}

// Returns the number of ticks that were run.
rt::Tick run_in_virtual_time(Runtime& runtime, Surroundings& surroundings, FlightRecorder& recorder,
                             ParameterDesk& desk, const LiveRunOptions& options, rt::Tick last) {
  runtime.executive().set_guard(heap_watch().arm);
  BenchFeed feed(surroundings, runtime, recorder, desk);
  constexpr rt::Tick kChunk = 256;
  for (rt::Tick tick = 0; tick <= last; tick += kChunk) {
    if (is_interrupted(options)) return tick;
    rt::run_virtual(runtime.executive(), feed, tick, std::min(last, tick + kChunk - 1));
    if (options.progress) options.progress(static_cast<double>(tick) / static_cast<double>(last + 1));
  }
  return last + 1;
}

std::string what_is_outside(const LiveRunOptions& options) {
  const std::string bus = options.can_interface.empty() ? "" : ", CAN on " + options.can_interface;
  return options.plant.empty() ? "live devices" : "a plant in a process of its own" + bus;
}

bool takes_channel(const Runtime& runtime, std::string_view channel) {
  const auto& ports = runtime.parts().ports();
  return std::any_of(ports.begin(), ports.end(),
                     [channel](const auto& port) { return port->channel() == channel; });
}

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

struct RunClock {
  rt::Nanoseconds start_ns;
};

}  // namespace

LiveRunOutcome run_live(const VehicleRegistry& vehicles, const BenchFactory& bench_factory,
                        const LiveRunOptions& options) {
  LiveRunOutcome outcome;
  BootedRuntime booted = boot_runtime(vehicles, options.scene, options.overrides, !options.virtual_time);
  outcome.runtime = std::move(booted.runtime);
  const UnitTrial& trial = booted.trial;
  Runtime& runtime = *outcome.runtime;
  rt::Executive& executive = runtime.executive();

  Profile for_bench = load_scene(options.scene, options.overrides);
  const bool is_outside = !options.can_interface.empty() || !options.plant.empty();
  if (is_outside && options.virtual_time)
    throw ProfileError("--virtual has its plant inside; leave out --plant and --can");
  std::unique_ptr<BenchRobot> bench =
      bench_factory && !is_outside ? bench_factory(for_bench, runtime.vehicle().scan_sink()) : nullptr;
  if (bench) {  // without one, nobody has declared what [hil] may hold
    for_bench.refuse_unknown_keys("hil");
    outcome.bench = bench->describe();
  }

  rt::posix::start_fast_clock();
  RunDoctor doctor;
  // Locked now, because locking takes long; the workers ask again and tell what was refused.
  const bool locks = !options.virtual_time && options.realtime;
  if (locks) {
    static_cast<void>(rt::posix::lock_memory());
    static_cast<void>(rt::posix::bound_thread_stacks(rt::posix::kThreadStackBytes));
  }
  RunFlightRing ring(runtime, options.flight_ring, options.virtual_time);
  PoseCollector collector(runtime);
  RecorderOptions recording;
  recording.path = options.record;
  recording.write_fields = options.record_fields;
  ChainWatch chains(runtime, !options.virtual_time);
  recording.on_job = [&collector, &chains](const rt::JobRecord& record) {
    collector.job(record);
    chains.job(record);
  };
  ParameterDesk parameters(runtime);
  std::vector<std::string> warnings;
  // A kernel that has just booted may take seconds for its first random number.
  if (!options.virtual_time) {
    if (const std::string note = parameters.open(options.lcm_url); !note.empty()) warnings.push_back(note);
  }
  // Everything that takes long is done: the run begins.
  RunClock clock{rt::posix::monotonic_now() + (options.virtual_time ? 0 : start_lead(runtime, locks))};
  const rt::Nanoseconds utc_minus_run = rt::posix::utc_minus_monotonic() + clock.start_ns;
  ring.set_clock(clock.start_ns, utc_minus_run - clock.start_ns);
  FlightRecorder recorder(runtime, recording,
                          make_header(runtime, bench ? bench->describe() : what_is_outside(options),
                                      options.virtual_time ? 0 : utc_minus_run));
  if (!options.record.empty()) {
    for (const auto& port : runtime.parts().ports()) port->set_sink(&recorder);
  }
  drivers::SocketCan can;
  if (!options.can_interface.empty()) {
    drivers::SocketCanConfig config;
    config.interface = options.can_interface;
    config.epoch_ns = clock.start_ns;
    std::string problem;
    if (can.open(config, problem) != Status::ok)
      throw ProfileError("--can " + options.can_interface + ": " + problem);
  }
  OutsideDevices outside{options.can_interface.empty() ? nullptr : &can, nullptr, clock.start_ns};
  std::unique_ptr<PlantLink> link;
  if (!options.plant.empty()) {
    const PlantLinkNeeds needs{outside.can == nullptr, runtime.vehicle().scan_sink(),
                               takes_channel(runtime, drivers::kChannelSsl)};
    link = std::make_unique<PlantLink>(parse_plant(options.plant), needs, clock.start_ns);
    outside.link = link.get();
    if (outside.can == nullptr) outside.can = link->can();
  }
  if (!options.virtual_time) write_log_clock(recorder, clock.start_ns, utc_minus_run);
  write_chosen_units(recorder, booted.chosen, trial.ns_per_unit);
  Surroundings surroundings(runtime, bench.get(), outside, recorder, !options.record.empty());
  executive.set_sink(ring.before(recorder.job_sink()));
  doctor.begin(executive, recorder, !options.virtual_time && options.realtime);
  executive.set_record_fields(true);
  executive.set_clock(
      [](void* self) { return rt::posix::fast_now() - static_cast<RunClock*>(self)->start_ns; }, &clock);

  const HeapWatch heap = heap_watch();
  const std::uint64_t heap_before = heap.calls != nullptr ? heap.calls() : 0;
  const auto length = std::llround(options.seconds * 1e9 / static_cast<double>(executive.base_tick_ns()));
  const auto last = static_cast<rt::Tick>(std::max(length, 1LL) - 1);  // one tick at least
  OwnedPart<Telemetry, rt::Part::telemetry> telemetry;
  if constexpr (rt::kBuilt<rt::Part::telemetry>) {
    if (runtime.outlets().telemetry)
      telemetry = std::make_unique<Telemetry>(runtime, recorder, parameters, options.lcm_url, utc_minus_run);
  }
  if (telemetry && !telemetry->problem().empty()) warnings.push_back(telemetry->problem());
  warnings.insert(warnings.end(), ring.warnings().begin(), ring.warnings().end());
  if (!doctor.warning().empty()) warnings.push_back(doctor.warning());
  if (const std::string tight = unit_warning(trial); !tight.empty()) warnings.push_back(tight);
  const auto began = std::chrono::steady_clock::now();
  rt::Tick ticks = 0;
  LiveMeasured live;
  if (options.virtual_time) {
    if (!bench)
      throw ProfileError(options.scene +
                         (*rt::kOnlyScene == '\0'
                              ? ": --virtual needs a scene with a simulated robot ([hil])"
                              : ": this program was built for one scene and has no simulated robot; "
                                "take the program with all scenes, or give --can or --plant"));
    ticks = run_in_virtual_time(runtime, surroundings, recorder, parameters, options, last);
  } else {
    recorder.start();
    if (telemetry) telemetry->start();
    EventDesk desk(runtime, recorder, telemetry.get(), ring, utc_minus_run);
    if (!ring.before_this().empty()) desk.tell("run_before", "run", ring.before_this(), 0);
    live = run_in_real_time({runtime, surroundings, parameters, recorder, desk, chains}, options,
                            clock.start_ns, last);
    ticks = live.ticks;
    if (telemetry) telemetry->stop();
    if (options.require_realtime && !live.warnings.empty()) throw RealtimeRefused(live.warnings.front());
    warnings.insert(warnings.end(), live.warnings.begin(), live.warnings.end());
    if (!live.late_start.empty()) warnings.push_back(live.late_start);
    outcome.stopped = live.stopped;
  }
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  ring.finish(executive.time_of(ticks));
  if (ring.stays()) outcome.flight_ring = ring.path();
  DoctorReport health = doctor.finish(executive, recorder, executive.time_of(ticks));
  Results& results = outcome.results;
  results = collect_results(runtime, ticks);
  results.counters.insert(live.counters.begin(), live.counters.end());
  if (heap.calls != nullptr) results.counters["heap_calls"] = heap.calls() - heap_before;
  add_live(results, live, options.virtual_time);
  if (!options.virtual_time) write_measured(recorder, results, executive.time_of(ticks));
  recorder.stop();

  outcome.estimate = collector.poses.take();
  outcome.truth = surroundings.truth.poses.take();
  outcome.contacts = surroundings.truth.contacts.take();
  tidy(outcome.estimate);
  tidy(outcome.truth);
  if (!outcome.truth.empty() && !outcome.estimate.empty()) {
    outcome.evaluation = evaluate(outcome.estimate, outcome.truth, options.evaluation);
  }
  chains.add_to(results);
  outcome.failures = unused_streams(runtime, pushed_streams(runtime), false);
  results.warnings.insert(results.warnings.begin(), outcome.failures.begin(), outcome.failures.end());
  if (options.virtual_time) {
    const std::vector<std::string> exceeded = exceeded_bounds(results);
    outcome.failures.insert(outcome.failures.end(), exceeded.begin(), exceeded.end());
  }
  if (!outcome.stopped.empty()) results.warnings.push_back(outcome.stopped);
  results.errors = outcome.evaluation.errors;
  results.duration_s = static_cast<double>(ticks) * static_cast<double>(executive.base_tick_ns()) * 1e-9;
  results.speed = wall > 0 ? results.duration_s / wall : 0;
  if (!trial.task.empty()) {
    results.counters["calibration_" + trial.task + "_ps_per_unit"] =
        static_cast<std::uint64_t>(std::llround(1e3 * trial.ns_per_unit));
  }
  for (const ChosenUnits& chosen : booted.chosen) {
    results.counters["calibration_" + chosen.task + "_units"] = chosen.units;
    if (!chosen.timed)
      results.warnings.push_back("tasks." + chosen.task +
                                 ".units = \"auto\": nothing timed them here; "
                                 "the default was taken, " +
                                 std::to_string(chosen.units));
  }
  results.counters["log_events"] = recorder.events();
  results.counters["log_bytes"] = recorder.bytes();
  results.counters["log_lost_jobs"] = recorder.lost_jobs();
  results.counters["log_lost_samples"] = recorder.lost_samples();
  if (telemetry) {
    results.counters["lcm_published"] = telemetry->counters().published;
    results.counters["lcm_dropped"] = telemetry->counters().dropped;
  }
  if (!options.virtual_time) {  // what telling the outside cost, on ordinary threads
    results.counters["recorder_cpu_us"] = microseconds_of(recorder.cpu_ns());
    if (telemetry) results.counters["telemetry_cpu_us"] = microseconds_of(telemetry->cpu_ns());
  }
  if (!runtime.parts().parameters().all.empty())
    add_counters("parameters_", parameters.counters(), results.counters);
  if (const drivers::LcmReceiverCounters* network = parameters.network(); network != nullptr) {
    results.counters["network_messages"] = network->messages;
    results.counters["network_fragments"] = network->fragments;
    results.counters["network_malformed"] = network->malformed;
    results.counters["network_socket_errors"] = network->socket_errors;
  }
  if (parameters.drive().wanted()) add_counters("requests_", parameters.drive().counters(), results.counters);
  if (parameters.fly().wanted()) add_counters("requests_", parameters.fly().counters(), results.counters);
  if (bench) bench->add_counters(results.counters);
  if (!outcome.contacts.empty())
    results.counters["bench_truth_contacts_dropped"] = surroundings.truth.contacts_dropped;
  if (link) {
    link->add_counters(results.counters);
    const std::vector<std::string> silences = link->warnings();
    warnings.insert(warnings.end(), silences.begin(), silences.end());
  }
  if (const std::string problem = recorder.error(); !problem.empty()) warnings.push_back(problem);
  results.warnings.insert(results.warnings.end(), warnings.begin(), warnings.end());
  results.doctor = std::move(health);
  return outcome;
}

}  // namespace sortie::firmware
