// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay.hpp"

#include <chrono>

#include "firmware_like/log/log_clock.hpp"
#include "firmware_like/log/log_event.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/log/named_fault.hpp"
#include "firmware_like/log/replay_observer.hpp"
#include "firmware_like/log/replay_part.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "rt/posix/fast_clock.hpp"
#include "rt/posix/threaded_runner.hpp"

namespace sortie::firmware {

namespace {

// Progress is the only thing that happens between ticks; it goes through a feed so that both runners can show
// it.
class ProgressFeed final : public rt::JobFeed {
 public:
  ProgressFeed(LogFeed& feed, Runtime& runtime, const ReplayOptions& options, LogRecorder* recorder)
      : feed_(feed), runtime_(runtime), options_(options), recorder_(recorder) {}
  void before_tick(rt::Tick tick) override {
    if (options_.on_tick) options_.on_tick(tick, runtime_, feed_);
    if (recorder_ != nullptr && tick % 64 == 0) recorder_->drain();
    if (tick % 1024 == 0) rt::posix::anchor_fast_clock();
    if (!options_.progress || tick % 1024 != 0 || feed_.last_tick() <= feed_.first_tick() ||
        tick < feed_.first_tick())
      return;
    options_.progress(static_cast<double>(tick - feed_.first_tick()) /
                      static_cast<double>(feed_.last_tick() - feed_.first_tick()));
  }
  bool prepare(std::uint32_t group, std::uint64_t job, rt::Tick tick, rt::JobOrder& order) override {
    return feed_.prepare(group, job, tick, order);
  }

 private:
  LogFeed& feed_;
  Runtime& runtime_;
  const ReplayOptions& options_;
  LogRecorder* recorder_;
};

// Source of a log that a replay writes: it has the verdicts of the run that was replayed.
constexpr const char* kReplayOf = "replay of ";

// In simulated time nothing comes late by accident.
bool is_simulated(const LogFile& log) {
  return log.header().has_ticks && log.header().utc_minus_monotonic_ns == 0;
}

// The times in a log are those of one profile, job by job: a what-if has none.
std::string why_not_live(const LogFile& log, const ReplayOptions& options, bool use_ticks) {
  if (std::string why = why_no_times(log); !why.empty()) return why;
  if (!options.scene.empty() || !options.overrides.empty())
    return "holds the times of its own scene; leave out --scene and --set";
  return use_ticks ? "" : "holds the jobs of another build; take the version that recorded it";
}

// What was true in the log is true of its replay.
std::unique_ptr<LogRecorder> open_recorder(const LogFile& log, Runtime& runtime, const std::string& path) {
  RecorderOptions recording;
  recording.path = path;
  auto recorder =
      std::make_unique<LogRecorder>(runtime, recording, make_header(runtime, kReplayOf + log.path(), 0));
  for (const auto& port : runtime.parts().ports()) port->set_sink(recorder.get());
  for (const std::string_view channel :
       {drivers::kChannelTruth, drivers::kChannelContacts, drivers::kChannelSensorTruth}) {
    for (const StoredEvent& stored : log.channel(std::string(channel))) {
      recorder->sample(std::string(channel), stored.timestamp_us * rt::kNanosecondsPerMicrosecond,
                       stored.message);
    }
  }
  return recorder;
}

// Streams and channels of which nothing was used, and declared bounds that were exceeded where nothing can
// come late by accident. `must_be_offered`: as of unused_streams().
void add_failures(ReplayOutcome& outcome, const LogFile& log, const LogFeed& feed,
                  const ReplayOptions& options, bool must_be_offered) {
  Results& results = outcome.results;
  const std::vector<StreamUse> uses = feed.stream_use();
  std::vector<std::string> unused = unused_streams(*outcome.runtime, uses, must_be_offered);
  const std::vector<std::string> homeless =
      channels_without_stream(results.scene, uses, feed.unused_channels(), !log.header().has_ticks);
  unused.insert(unused.end(), homeless.begin(), homeless.end());
  results.warnings.insert(results.warnings.begin(), unused.begin(), unused.end());
  for (const std::string& name : feed.unused_channels()) {
    if (!homeless.empty()) break;  // told already
    results.warnings.push_back("channel " + name + " is not used by scene " + results.scene);
  }
  if (!options.accept_unused) outcome.failures = std::move(unused);
  if (!is_simulated(log)) return;
  const std::vector<std::string> exceeded = exceeded_bounds(results);
  outcome.failures.insert(outcome.failures.end(), exceeded.begin(), exceeded.end());
}

void judge_comparable(ReplayOutcome& outcome, const LogFile& log, const ReplayOptions& options) {
  outcome.why_not_comparable = why_not_comparable(log, options, *outcome.runtime);
  outcome.comparable = outcome.why_not_comparable.empty();
  if (options.must_compare && !outcome.comparable) {
    throw InputError(
        log.path() + ": cannot be checked: " + outcome.why_not_comparable + "; `sortie replay` still runs it",
        2);
  }
}

// Where a replay's jobs go.
struct JobSinks {
  ReplayObserver* observer;
  LogRecorder* recorder;  // null where the replay is not recorded
  static void take(void* self, const rt::JobRecord& record) {
    auto* both = static_cast<JobSinks*>(self);
    if (both->recorder != nullptr) both->recorder->job_sink().call(both->recorder, record);
    both->observer->job(record);
  }
};

// All jobs; gives the seconds that they took on the wall.
double run_jobs(rt::Executive& executive, ProgressFeed& feed, bool threaded, rt::Tick begin, rt::Tick last) {
  const auto began = std::chrono::steady_clock::now();
  if (threaded) {
    rt::posix::run_virtual_threaded(executive, feed, begin, last);
  } else {
    rt::run_virtual(executive, feed, begin, last);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

void take_figures(ReplayOutcome& outcome, const LogFile& log, const LogFeed& feed, double wall_s) {
  Results& results = outcome.results;
  results = collect_results(*outcome.runtime, feed.last_tick() - outcome.first_tick + 1);
  const auto tick_ns = static_cast<double>(outcome.runtime->executive().base_tick_ns());
  results.duration_s = static_cast<double>(results.ticks) * tick_ns * 1e-9;
  results.speed = wall_s > 0 ? results.duration_s / wall_s : 0;
  results.counters["log_events"] = log.events();
  results.counters["samples_missing"] = feed.missing_samples();
  results.counters["samples_damaged"] = feed.damaged_samples();
  results.counters["samples_refused"] = feed.refused_samples();
}

void refuse_early_fault(const std::string& fault, rt::Tick tick, rt::Tick begin) {
  if (tick >= begin) return;
  throw InputError(
      "--fault " + fault + ": lies before tick " + std::to_string(begin) + ", where this replay begins", 2);
}

// Of the log, of what it did not hold, and of digests. `inexact_truth`: the log of a truth whose clock is
// another.
void add_warnings(ReplayOutcome& outcome, const LogFile& log, const LogFeed& feed, bool use_ticks,
                  const std::string& inexact_truth) {
  Results& results = outcome.results;
  const std::vector<std::string> problems = log.problems();
  results.doctor = recorded_doctor(log);
  results.warnings.insert(results.warnings.begin(), problems.begin(), problems.end());
  outcome.damage = feed.damage().empty() ? log.damage() : feed.damage();
  if (!inexact_truth.empty())
    results.warnings.push_back(
        inexact_truth + ": of another machine or start of it; laid beside the run by their dates (UTC)");
  if (!feed.damage().empty()) results.warnings.push_back(feed.damage());
  if (feed.jobs_left_out() != 0) {
    results.warnings.push_back(
        std::to_string(feed.jobs_left_out()) +
        " jobs at the end of the log are left out: it does not hold all that they took");
  }
  if (log.header().has_ticks && !outcome.comparable) {
    results.warnings.push_back("digests are not comparable with the log: " + outcome.why_not_comparable +
                               (use_ticks ? "" : "; its samples go to the jobs by their times of receipt"));
  }
}

}  // namespace

std::unique_ptr<Runtime> make_replay_runtime(const LogFile& log, const VehicleRegistry& vehicles,
                                             const ReplayOptions& options) {
  const drivers::LogHeader& header = log.header();
  if (options.scene.empty() && header.scene_toml.empty()) {
    throw ProfileError(log.path() +
                       " was imported and names no scene; add --scene NAME (`sortie scenes` lists them)");
  }
  if (options.scene.empty()) refuse_unknown_vehicle(log, vehicles);
  const auto load = [&](const std::vector<std::string>& overrides) {
    return options.scene.empty() ? Profile(header.scene_toml, log.path() + " (profile)", overrides)
                                 : load_scene(options.scene, overrides);
  };
  Profile profile = load(options.overrides);
  RuntimeStart start;
  const std::vector<KeptMap> maps = read_kept_maps(options.maps);
  start.maps = maps;
  // A log that was recorded with a map says which; for others it is a what-if.
  std::vector<KeptMap> others;
  std::copy_if(maps.begin(), maps.end(), std::back_inserter(others),
               [&profile](const KeptMap& map) { return !profile.has(map.table + ".map_digest"); });
  if (!others.empty()) profile = load(overrides_of(others, options.overrides));
  start.epoch_ns = header.epoch_ns;
  start.has_initial = true;
  for (int i = 0; i < 3; ++i) start.initial.p_world_body_m[i] = header.initial_p[i];
  for (int i = 0; i < 4; ++i) start.initial.q_world_body[i] = header.initial_q[i];
  return std::make_unique<Runtime>(std::move(profile), vehicles, start);
}

ReplayOutcome replay(const LogFile& log, const VehicleRegistry& vehicles, const ReplayOptions& options) {
  const drivers::LogHeader& header = log.header();
  // Read first: what cannot be used is told before the replay, not after it.
  std::unique_ptr<TruthLog> truth;
  if (!options.truth.empty()) truth = std::make_unique<TruthLog>(log, options.truth);
  ReplayOutcome outcome;
  outcome.runtime = make_replay_runtime(log, vehicles, options);
  Runtime& runtime = *outcome.runtime;
  rt::Executive& executive = runtime.executive();
  judge_comparable(outcome, log, options);
  // Another profile takes the same jobs with the same samples again, as long as it has the same groups at the
  // same phases.
  const bool use_ticks = header.has_ticks && reads_ticks(log) && header.groups == runtime.group_table();
  rt::TaskBase* faulty = nullptr;
  rt::Tick fault_tick = ~rt::Tick{0};
  if (!options.fault.empty()) {
    const NamedFault fault = parse_fault(executive, options.fault, true);
    faulty = &executive.task(fault.task);
    fault_tick = fault.tick;
    faulty->plant_fault({true, fault.tick, fault.byte.value_or(faulty->output_bytes() - 1)});
  }

  LogFeed feed(log, runtime, use_ticks);
  choose_part(log, options, outcome, feed);
  refuse_early_fault(options.fault, fault_tick, outcome.begin_tick);
  const std::unique_ptr<LogRecorder> recorder =
      options.record.empty() ? nullptr : open_recorder(log, runtime, options.record);
  const bool whole = options.from.empty() && options.to.empty();
  ReplayObserver observer(outcome, feed, options, options.from.empty() ? 0 : outcome.first_tick,
                          is_simulated(log) && header.source.rfind(kReplayOf, 0) != 0,
                          RecordedTimes(log, runtime, why_not_live(log, options, use_ticks), whole));
  JobSinks sinks{&observer, recorder.get()};
  executive.set_sink({&sinks, JobSinks::take});
  executive.set_record_fields(true);
  rt::posix::start_fast_clock();
  executive.set_clock([](void*) { return rt::posix::fast_now(); }, nullptr);
  const HeapWatch heap = heap_watch();
  const std::uint64_t heap_before = heap.calls != nullptr ? heap.calls() : 0;
  executive.set_guard(heap.arm);

  if (options.before_run) options.before_run(runtime);
  ProgressFeed shown(feed, runtime, options, recorder.get());
  const double wall_s = run_jobs(executive, shown, options.threaded, outcome.begin_tick, feed.last_tick());
  if (recorder) recorder->stop();
  if (faulty != nullptr && faulty->waits_for_fault()) refuse_unmet_fault(options.fault);

  tidy(outcome.estimate);
  tidy(outcome.located);
  outcome.truth = truth ? std::move(truth->poses) : log.truth();
  outcome.contacts = truth ? contact_summaries(truth->log, truth->offset.offset_ns) : contact_summaries(log);
  outcome.recorded = feed.recorded_digest();
  take_figures(outcome, log, feed, wall_s);
  Results& results = outcome.results;
  if (heap.calls != nullptr) results.counters["heap_calls"] = heap.calls() - heap_before;
  observer.times.add_to(results);
  observer.chains.add_to(results);
  add_failures(outcome, log, feed, options, whole && !use_ticks);
  add_warnings(outcome, log, feed, use_ticks, truth && !truth->offset.exact ? options.truth : "");
  return outcome;
}

}  // namespace sortie::firmware
