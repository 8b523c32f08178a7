// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_recorder.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "drivers/lcm_log.hpp"
#include "firmware_like/runtime/owned_part.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/file_place.hpp"
#include "rt/posix/make_thread.hpp"

namespace sortie::firmware {

// A build of a scene without recorder neither makes nor destroys a writer.
struct LogRecorder::Log {
  OwnedPart<rt::posix::FilePlace, "recorder"> place;
  OwnedPart<drivers::LcmLogWriter, "recorder"> writer;
};

inline bool LogRecorder::has_log() const { return rt::kBuilt<"recorder"> && log_ != nullptr; }

LogRecorder::LogRecorder(const Runtime& runtime, const RecorderOptions& options,
                         const drivers::LogHeader& header)
    : runtime_(runtime), options_(options), current_(std::make_unique<rt::JobRecord>()) {
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    slots_.push_back(std::make_unique<rt::JobRecord[]>(options.jobs_per_group));
    rings_.push_back(
        std::make_unique<rt::SpscSpanRing<rt::JobRecord>>(slots_.back().get(), options.jobs_per_group));
    histograms_.emplace_back(executive.group(i).tasks.size());
  }
  missed_.resize(executive.group_count());
  for (std::uint32_t i = 0; i < executive.group_count(); ++i)
    whole_.push_back(executive.group(i).timing.release(0));
  if (options.path.empty()) return;
  if (!rt::kBuilt<"recorder"> || !runtime.outlets().recorder)
    throw ProfileError(rt::kBuilt<"recorder">
                           ? "live.recorder = false in " + runtime.profile().name() +
                                 ": it is not recorded; leave out --record, or take --set live.recorder=true"
                           : not_in_this_build("recorder", runtime.profile().name()));
  if constexpr (rt::kBuilt<"recorder">) open_log(header);
}

void LogRecorder::open_log(const drivers::LogHeader& header) {
  log_ = std::make_unique<Log>();
  log_->place = std::make_unique<rt::posix::FilePlace>(options_.path);
  log_->writer = std::make_unique<drivers::LcmLogWriter>(log_->place->second_descriptor(), options_.path,
                                                         kLogBufferBytes);
  buffer_.resize(drivers::encoded_bytes(header) + sizeof(rt::JobRecord) + 1024);
  std::size_t size = 0;
  if (drivers::encode(header, buffer_, size) != Status::ok) {
    throw std::runtime_error(options_.path +
                             ": the log's header cannot be encoded; a text in the profile holds a zero byte");
  }
  if (!append(drivers::kChannelHeader, header.epoch_ns / 1000, {buffer_.data(), size}))
    throw std::runtime_error(options_.path + ": the log's header is too large for an event of a log");
  if (!log_->writer->error().empty()) throw std::runtime_error(log_->writer->error());
}

LogRecorder::~LogRecorder() { end(); }

std::size_t LogRecorder::bytes_for(const Runtime& runtime, bool has_log) {
  const rt::Executive& executive = runtime.executive();
  const std::size_t queues =
      executive.group_count() * RecorderOptions{}.jobs_per_group * sizeof(rt::JobRecord);
  const std::size_t histograms = executive.task_count() * sizeof(rt::LatencyHistogram);
  return sizeof(LogRecorder) + queues + histograms + (has_log ? kLogBufferBytes : 0);
}

void LogRecorder::job(const rt::JobRecord& record) {
  if (!rings_[record.group]->try_push(record)) lost_jobs_.fetch_add(1, std::memory_order_relaxed);
}

void LogRecorder::sample(const std::string& channel, rt::Nanoseconds stamp_ns,
                         std::span<const std::uint8_t> message) {
  if (!has_log()) return;
  const std::lock_guard lock(samples_mutex_);
  const std::size_t cost = sizeof(QueuedSample) + message.size();
  if (waiting_bytes_ + cost > options_.sample_bytes) {
    lost_samples_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  waiting_bytes_ += cost;
  samples_.push_back({channel, stamp_ns / 1000, {message.begin(), message.end()}});
}

bool LogRecorder::append(std::string_view channel, std::int64_t stamp_us,
                         std::span<const std::uint8_t> bytes) {
  // A file that cannot take more says so in error(), counts every refusal, and keeps what it has. What no log
  // may hold (a bad channel, more bytes than an event has) is for the caller to count.
  return log_->writer->append(channel, stamp_us, bytes) != Status::malformed;
}

void LogRecorder::write_gap(rt::Tick tick, std::uint64_t lost, const char* reason) {
  std::size_t size = 0;
  const drivers::GapRecord gap{static_cast<std::int64_t>(tick), -1, static_cast<std::int64_t>(lost), reason};
  if (drivers::encode(gap, buffer_, size) == Status::ok) {
    static_cast<void>(append(drivers::kChannelGap, runtime_.executive().time_of(tick) / 1000,
                             {buffer_.data(), size}));  // small, and its channel is one
  }
}

bool LogRecorder::write_job(rt::JobRecord& record) {
  if (!options_.write_fields) record.field_bytes = 0;
  std::size_t size = 0;
  const rt::Nanoseconds released = runtime_.executive().time_of(record.tick);
  if (drivers::encode(record, buffer_, size) != Status::ok ||
      !append(drivers::kChannelTick, released / 1000, {buffer_.data(), size}))
    return false;
  const drivers::JobTiming timing{static_cast<std::int64_t>(record.tick),
                                  record.group,
                                  record.started_ns,
                                  {record.duration_ns, record.tasks}};
  // How long it took is no input of a replay.
  if (drivers::encode(timing, buffer_, size) == Status::ok)
    static_cast<void>(append(drivers::kChannelTiming, released / 1000, {buffer_.data(), size}));
  return true;
}

void LogRecorder::drain() {
  // Jobs that wait now are counted first, then all samples are written, then those jobs: so a sample always
  // stands in the log before the job that consumed it.
  std::uint32_t ready[rt::kMaxGroups]{};
  for (std::size_t group = 0; group < rings_.size(); ++group) ready[group] = rings_[group]->size();
  // What is lost from here on can only touch jobs behind the newest that every group has in the log by now.
  const rt::Tick whole_until = this->whole_until();
  std::vector<QueuedSample> samples;
  {
    const std::lock_guard lock(samples_mutex_);
    samples.swap(samples_);
    waiting_bytes_ = 0;
  }
  // What no log may hold is as lost as what came too fast.
  for (const QueuedSample& queued : samples) {
    if (!append(queued.channel, queued.stamp_us, queued.bytes))
      lost_samples_.fetch_add(1, std::memory_order_relaxed);
  }
  for (std::size_t group = 0; group < rings_.size(); ++group) {
    for (std::uint32_t i = 0; i < ready[group] && rings_[group]->try_pop(*current_); ++i) {
      {
        const std::lock_guard lock(statistics_);
        for (std::uint32_t task = 0; task < current_->tasks; ++task) {
          histograms_[group][task].record(current_->duration_ns[task]);
        }
        if (current_->verdict == rt::Verdict::missed) ++missed_[group];
      }
      if (options_.on_job) options_.on_job(*current_);
      whole_[group] =
          runtime_.executive().group(static_cast<std::uint32_t>(group)).timing.release(current_->job + 1);
      if (has_log() && !write_job(*current_)) lost_jobs_.fetch_add(1, std::memory_order_relaxed);
      has_jobs_ = true;
    }
  }
  if (!has_log()) return;
  note_written();
  if (has_jobs_ && !log_->place->taken() && log_->writer->flush() == Status::ok) take_place();
  const auto tell = [&](std::uint64_t lost, std::uint64_t& reported, const char* reason) {
    if (lost != reported) write_gap(whole_until, lost - reported, reason);
    reported = lost;
  };
  tell(lost_jobs_.load(), reported_jobs_, "jobs were lost: the disk was too slow, or no log may hold them");
  tell(lost_samples_.load(), reported_samples_,
       "samples were lost: the disk was too slow, or no log may hold them");
}

rt::Tick LogRecorder::whole_until() const { return *std::min_element(whole_.begin(), whole_.end()); }

// Only while the file takes what it is given: what it refuses has no place in it, and its events are counted
// back to those that the disk took.
void LogRecorder::note_written() {
  if (!log_->writer->error().empty()) return;
  // Longer than anything waits in the writer's buffer: older ones are on the disk.
  constexpr std::size_t kMost = 1u << 12;
  if (written_.size() == kMost) written_.erase(written_.begin(), written_.begin() + kMost / 2);
  written_.push_back({log_->writer->events(), whole_until()});
}

void LogRecorder::take_place() {
  std::string refused = log_->place->take(rt::posix::FormerFile::kept);
  if (!refused.empty()) place_refused_ = std::move(refused);
}

void LogRecorder::close_log() {
  static_cast<void>(log_->writer->flush());
  if (!log_->writer->error().empty()) {
    // The file ends with what the disk took; a last event says in it that more was meant to come.
    rt::Tick end = 0;
    for (const Written& written : written_) {
      if (written.events <= log_->writer->events()) end = written.whole_until;
    }
    std::size_t size = 0;
    const auto lost = static_cast<std::int64_t>(log_->writer->lost() + log_->writer->refused());
    const drivers::GapRecord gap{static_cast<std::int64_t>(end), -1, lost,
                                 "events were lost: the disk was full or failed"};
    if (drivers::encode(gap, buffer_, size) == Status::ok) {
      static_cast<void>(log_->writer->append_last(drivers::kChannelGap,
                                                  runtime_.executive().time_of(end) / 1000,
                                                  {buffer_.data(), size}));  // no room: error() still tells
    }
  }
  static_cast<void>(log_->writer->close());  // what went wrong stands in error()
}

void LogRecorder::start() {
  thread_ = rt::posix::make_thread("the recorder", [this] {
    for (int round = 1; !stop_.load(std::memory_order_relaxed); ++round) {
      drain();
      if (has_log() && round % 200 == 0)
        static_cast<void>(log_->writer->start_writeback());  // about once a second
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    cpu_ns_.store(rt::posix::thread_cpu_now(), std::memory_order_relaxed);
  });
}

void LogRecorder::end() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  drain();
  if (has_log()) close_log();
}

void LogRecorder::stop() {
  end();
  if (has_log() && !log_->place->occupied()) take_place();
}

std::uint64_t LogRecorder::bytes() const { return has_log() ? log_->writer->bytes() : 0; }

std::uint64_t LogRecorder::events() const { return has_log() ? log_->writer->events() : 0; }

bool LogRecorder::log_is_there() const { return has_log() && log_->place->taken(); }

std::string LogRecorder::former_log() const {
  return has_log() && log_->place->former_kept() ? log_->place->previous() : std::string();
}

std::string LogRecorder::error() const {
  if (!place_refused_.empty()) return place_refused_;
  if (has_log() && !log_->writer->error().empty()) return log_->writer->error();
  if (lost_jobs() + lost_samples() != 0) {
    return "the log has gaps: " + std::to_string(lost_jobs()) + " jobs and " +
           std::to_string(lost_samples()) +
           " samples were lost before the disk took them, or are larger than an event of a log may be; use a "
           "faster disk, or leave out --record-fields";
  }
  return {};
}

drivers::LogHeader make_header(const Runtime& runtime, const std::string& source,
                               rt::Nanoseconds utc_minus_run) {
  drivers::LogHeader header;
  header.version = version();
  header.compiler = compiler_description();
  header.vehicle = runtime.profile().vehicle();
  header.scene = runtime.profile().name();
  header.scene_toml = runtime.profile().canonical();
  header.scene_hash = static_cast<std::int64_t>(runtime.profile().hash());
  header.base_tick_ns = runtime.executive().base_tick_ns();
  header.epoch_ns = runtime.executive().epoch_ns();
  header.utc_minus_monotonic_ns = utc_minus_run;
  header.has_ticks = true;
  for (int i = 0; i < 3; ++i) header.initial_p[i] = runtime.initial_pose().p_world_body_m[i];
  for (int i = 0; i < 4; ++i) header.initial_q[i] = runtime.initial_pose().q_world_body[i];
  header.groups = runtime.group_table();
  header.tasks = runtime.task_table();
  header.source = source;
  return header;
}

std::string version() { return SORTIE_VERSION; }

}  // namespace sortie::firmware
