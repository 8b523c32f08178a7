// SPDX-License-Identifier: BSD-3-Clause
// Runs of the own vehicles in tests: on a virtual clock, recorded, their logs rewritten event by event.
#pragma once

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/lcm_url.hpp"
#include "firmware_like/live/live_run.hpp"
#include "firmware_like/log/replay.hpp"
#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/firmware_like/temp_folder.hpp"
#include "tests/rt/undisturbed.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/simulate/simulated_ugv.hpp"

namespace sortie::testing {

using firmware::watch_heap;

/// A run of ugv_hall on a virtual clock with a small lidar, so that it costs a fraction of a second.
inline firmware::LiveRunOutcome run_hall(double seconds, const std::string& record = "",
                                         bool record_fields = false) {
  firmware::LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=8", "hil.lidar_columns=128", "limits.voxels=32768"};
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = record;
  options.record_fields = record_fields;
  options.lcm_url = "none";
  return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
}

/// A live run on a machine that does not go away for half of it: whoever counts its jobs needs some.
inline firmware::LiveRunOutcome run_live_undisturbed(const firmware::VehicleRegistry& vehicles,
                                                     const firmware::SimulatorFactory& simulator,
                                                     const firmware::LiveRunOptions& options) {
  const auto half = std::chrono::milliseconds(static_cast<int>(500 * options.seconds));
  return undisturbed(half, [&] { return firmware::run_live(vehicles, simulator, options); });
}

inline firmware::ReplayOutcome replay_log(const std::string& path,
                                          const firmware::ReplayOptions& options = {}) {
  const firmware::LogFile log(path);
  return firmware::replay(log, firmware::own_vehicles(), options);
}

/// A live run of ugv_hall on a thread of its own, heard over LCM: two minutes, or until it is ended.
class HallOverLcm {
 public:
  HallOverLcm(const std::string& record, std::vector<std::string> overrides)
      : running_([this, record, overrides = std::move(overrides)]() mutable {
          firmware::LiveRunOptions options;
          options.scene = "ugv_hall";
          options.overrides = std::move(overrides);
          options.overrides.insert(options.overrides.end(),
                                   {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768"});
          options.seconds = 120;
          options.realtime = false;
          options.record = record;
          options.lcm_url = drivers::kDefaultLcmUrl;
          options.interrupted = &enough_;
          run_ = firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
        }) {}
  ~HallOverLcm() { static_cast<void>(end()); }
  HallOverLcm(const HallOverLcm&) = delete;
  HallOverLcm& operator=(const HallOverLcm&) = delete;

  /// Ends the run and gives its outcome.
  const firmware::LiveRunOutcome& end() {
    enough_.store(true);
    if (running_.joinable()) running_.join();
    return run_;
  }

 private:
  std::atomic<bool> enough_{false};
  firmware::LiveRunOutcome run_;
  std::thread running_;  // last: it uses all of the above
};

/// A run of ugv_hall with fields and its log, which lives as long as this.
struct RecordedHall {
  explicit RecordedHall(double seconds) : run(run_hall(seconds, log, true)) {}
  TempFolder folder;
  std::string log = folder.file("hall.lcm");
  firmware::LiveRunOutcome run;
};

/// Two seconds of ugv_hall with fields, recorded once a program.
inline const RecordedHall& two_seconds() {
  static const RecordedHall recorded(2);
  return recorded;
}

inline std::uint64_t counter(const firmware::ReplayOutcome& outcome, const std::string& name) {
  return outcome.results.counters.at(name);
}

/// Errors of a run or a replay against its truth.
template <class Outcome>
std::map<std::string, double> errors_of(const Outcome& outcome) {
  return toolchain::evaluate(outcome.estimate, outcome.truth).errors;
}

/// What a replay has to complain of, over however much of the log is left; empty when nothing.
inline std::string complaint_of(const firmware::ReplayOutcome& outcome) {
  if (outcome.divergence) return firmware::describe(*outcome.divergence);
  if (!outcome.comparable) return "not comparable: " + outcome.why_not_comparable;
  if (outcome.diverged_jobs != 0) return "jobs diverged, and none is named";
  if (firmware::hex(outcome.recorded.all) != outcome.results.digest) return "another digest than in the log";
  for (const char* name : {"samples_missing", "samples_damaged", "samples_refused"}) {
    if (outcome.results.counters.at(name) != 0) return name;
  }
  return {};
}

/// True when the text, or one of the lines, holds `part`.
inline bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}
inline bool mentions(const std::vector<std::string>& lines, const std::string& part) {
  for (const std::string& line : lines) {
    if (mentions(line, part)) return true;
  }
  return false;
}

/// One event that may be changed on its way into a rewritten log.
struct EditableEvent {
  std::string channel;
  std::int64_t timestamp_us{};
  std::vector<std::uint8_t> bytes;
};

/// Copies a log; `keep(event, index within its channel)` may change an event, or drop it with false.
inline void rewrite_log(const std::string& from, const std::string& to,
                        const std::function<bool(EditableEvent&, std::size_t)>& keep) {
  drivers::LcmLogReader reader(from);
  drivers::LcmLogWriter writer(to);
  std::map<std::string, std::size_t> counts;
  drivers::LogEvent event;
  while (reader.next(event) == Status::ok) {
    EditableEvent copy{
        std::string(event.channel), event.timestamp_us, {event.data.begin(), event.data.end()}};
    const std::size_t index = counts[copy.channel]++;
    if (keep(copy, index)) REQUIRE(writer.append(copy.channel, copy.timestamp_us, copy.bytes) == Status::ok);
  }
  REQUIRE(writer.close() == Status::ok);
}

/// The first `bytes` bytes of a file.
inline void cut_file(const std::string& from, const std::string& to, std::uint64_t bytes) {
  std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(to, bytes);
}

/// What an exception says, or an empty text when `call` does not throw E.
template <class E, class F>
std::string message_of(F call) {
  try {
    call();
  } catch (const E& error) {
    return error.what();
  }
  return {};
}

}  // namespace sortie::testing
