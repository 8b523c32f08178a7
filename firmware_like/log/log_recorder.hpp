// SPDX-License-Identifier: BSD-3-Clause
// Takes the jobs of a run from the workers and the samples from the drivers; keeps the statistics that
// telemetry shows and, if asked, writes the log.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/wire_records.hpp"
#include "drivers/wire_telemetry.hpp"
#include "firmware_like/runtime/input_port.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "rt/spsc_ring.hpp"

namespace sortie::firmware {

/// How much waits for the disk before something is lost.
struct RecorderOptions {
  std::string path;                                  ///< empty: no log, statistics only
  std::uint32_t jobs_per_group{1024};                ///< a power of two
  bool write_fields{};                               ///< put the outputs' fields into the log
  std::function<void(const rt::JobRecord&)> on_job;  ///< on the draining thread, for every job
  std::size_t sample_bytes{std::size_t{32} << 20};   ///< of samples that wait for the disk
};

/// Queues in front of a log. Workers call job(), drivers sample(), and neither waits for the disk; a thread
/// of its own writes. What does not fit is lost, counted, and said in the log as a GAP. The log is made
/// beside its path and takes the place with its first job (rt/posix/file_place.hpp); a former one is kept as
/// PATH.previous.
class LogRecorder final : public SampleSink {
 public:
  /// Makes the log and writes its header. Throws std::runtime_error when the file cannot be made,
  /// ProfileError when the scene or this build has no recorder and a log is asked for.
  LogRecorder(const Runtime& runtime, const RecorderOptions& options, const drivers::LogHeader& header);
  /// Without stop() before: the run was refused, and a log that holds no job goes away.
  ~LogRecorder() override;

  /// Sink for Executive::set_sink(). Real-time safe; one thread a group.
  rt::JobSink job_sink() {
    return {this,
            [](void* self, const rt::JobRecord& record) { static_cast<LogRecorder*>(self)->job(record); }};
  }
  /// From any driver thread.
  void sample(const std::string& channel, rt::Nanoseconds stamp_ns,
              std::span<const std::uint8_t> message) override;

  /// Starts the writing thread; stop() drains what waits, closes the file and reports. A log without a job is
  /// left then only where none was before. Throws ThreadRefused.
  void start();
  void stop();
  /// Without the thread: writes what waits now. For runs on a virtual clock.
  void drain();

  /// Memory of a recorder with the usual queues, beside or without a log.
  static std::size_t bytes_for(const Runtime& runtime, bool has_log);
  /// Processor time of the writing thread; 0 until stop().
  rt::Nanoseconds cpu_ns() const { return cpu_ns_.load(); }
  /// Timing of each task so far, in table order. Any thread.
  std::vector<drivers::TaskTiming> timings() const;
  std::uint64_t lost_jobs() const { return lost_jobs_.load(); }
  std::uint64_t lost_samples() const { return lost_samples_.load(); }
  /// Of the log; 0 without one.
  std::uint64_t bytes() const;
  std::uint64_t events() const;
  /// After stop(): the log stands at its path.
  bool log_is_there() const;
  /// After stop(): where the log of a run before was moved, or empty.
  std::string former_log() const;
  /// Empty, or why the log is not whole.
  std::string error() const;

 private:
  struct Log;  // of a build that may have none
  struct QueuedSample {
    std::string channel;
    std::int64_t stamp_us;
    std::vector<std::uint8_t> bytes;
  };

  static constexpr std::size_t kLogBufferBytes = std::size_t{1} << 20;

  bool has_log() const;
  void open_log(const drivers::LogHeader& header);
  void job(const rt::JobRecord& record);
  bool write_job(rt::JobRecord& record);
  void write_gap(rt::Tick tick, std::uint64_t lost, const char* reason);
  rt::Tick whole_until() const;
  void note_written();
  void close_log();
  void take_place();
  void end();
  bool append(std::string_view channel, std::int64_t stamp_us, std::span<const std::uint8_t> bytes);

  const Runtime& runtime_;
  RecorderOptions options_;
  std::unique_ptr<Log> log_;  // null: none is written
  std::vector<std::unique_ptr<rt::JobRecord[]>> slots_;
  std::vector<std::unique_ptr<rt::SpscSpanRing<rt::JobRecord>>> rings_;
  std::vector<std::vector<rt::LatencyHistogram>> histograms_;  // by group, by task
  std::vector<std::uint64_t> missed_;                          // by group
  std::vector<rt::Tick> whole_;  // by group: the log holds all its jobs before this tick, its next release
  mutable std::mutex statistics_;
  std::mutex samples_mutex_;
  std::vector<QueuedSample> samples_;
  std::size_t waiting_bytes_{};
  std::vector<std::uint8_t> buffer_;
  std::unique_ptr<rt::JobRecord> current_;
  /// After each round of writing: how many events there were, and how far they are whole, over all groups. So
  /// it is known up to where the log is whole when the disk took only so many of them.
  struct Written {
    std::uint64_t events;
    rt::Tick whole_until;
  };
  std::vector<Written> written_;
  bool has_jobs_{};
  std::atomic<std::uint64_t> lost_jobs_{};
  std::atomic<std::uint64_t> lost_samples_{};
  std::uint64_t reported_jobs_{};
  std::uint64_t reported_samples_{};
  std::string place_refused_;
  std::atomic<rt::Nanoseconds> cpu_ns_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// The header of a log of this runtime. `has_ticks`: jobs follow.
drivers::LogHeader make_header(const Runtime& runtime, const std::string& source,
                               rt::Nanoseconds utc_minus_run);

/// Version text of this build: number and, if known, the revision.
std::string version();

}  // namespace sortie::firmware
