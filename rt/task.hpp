// SPDX-License-Identifier: BSD-3-Clause
// A task: a function that fills one output struct at every release. Digest, field record, hand-over to other
// groups and telemetry follow from the struct's list of fields; the function does not know of them.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

#include "rt/archive.hpp"
#include "rt/digest.hpp"
#include "rt/histogram.hpp"
#include "rt/job_context.hpp"
#include "rt/job_record.hpp"
#include "rt/ladder.hpp"
#include "rt/let_channel.hpp"
#include "rt/mailbox.hpp"
#include "rt/ports.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// What a task is declared to be.
struct TaskSpec {
  const char* name{};
  std::uint32_t budget_us{};  ///< declared worst run time of one execution
  std::uint32_t units{};      ///< work units of one execution of an anytime task; 0: not an anytime task
  Criticality criticality{Criticality::a};  ///< who gives way under overload (rt/ladder.hpp)
};

/// Called once for every scalar of a value: name, index within an array or -1, the value as double, its raw
/// bits, and its bytes in the canonical form.
struct ScalarSink {
  void* self;
  void (*call)(void* self, const char* name, int index, double value, std::uint64_t bits,
               std::uint32_t bytes);
};

/// Flips the last bit of one field byte of a task's output at one tick: proof that a check can fail.
struct PlantedFault {
  bool armed{};
  Tick tick{};
  std::uint32_t byte{};
};

/// A task, as the executive sees it.
class TaskBase {
 public:
  TaskBase(const TaskSpec& spec, std::uint16_t group) : spec_(spec), group_(group) {}
  virtual ~TaskBase() = default;

  const char* name() const { return spec_.name; }
  std::uint16_t group() const { return group_; }
  std::uint32_t budget_us() const { return spec_.budget_us; }
  const TaskSpec& spec() const { return spec_; }
  /// Wall time of each execution. Read it after the run, or from the thread that runs the group.
  const LatencyHistogram& wall_time() const { return wall_time_; }
  /// Jobs in which the ladder left this task out.
  std::uint64_t shed() const { return shed_; }
  /// Jobs in which the wall-clock guard cut this task.
  std::uint64_t cut() const { return cut_; }
  /// Executions that took longer than the budget.
  std::uint64_t over_budget() const { return over_budget_; }
  /// Chain over (tick, digest) of every job so far.
  std::uint64_t chain() const { return chain_; }
  /// Bytes of the output's canonical form.
  virtual std::uint32_t output_bytes() const = 0;
  /// Walks the scalars of a canonical form of this task's output.
  virtual void describe(const std::uint8_t* canonical, ScalarSink sink) const = 0;
  /// Newest output for a non-real-time reader, as canonical form. False when nothing new. One reader thread.
  virtual bool poll_output(std::uint8_t* canonical) = 0;
  void plant_fault(PlantedFault fault) { fault_ = fault; }
  /// The job that it is planted in has not run.
  bool waits_for_fault() const { return fault_.armed; }
  /// Output and digest chain to bytes and back. Between jobs only, and not for the real-time path.
  virtual void archive(Archive& archive) {
    Members(archive, *this, spec_.name)
        .fixed(spec_, group_)
        .scratch(wall_time_, over_budget_, fault_)
        .state(chain_, shed_, cut_);
  }
  /// What the channel to other groups holds of the jobs first..end-1. The group's ledger comes before.
  virtual void archive_channel(Archive& archive, std::uint64_t first, std::uint64_t end) = 0;
  /// True when the task's function changes its own captures and does not archive them: nobody else can.
  virtual bool hides_state() const { return false; }

 protected:
  friend class Executive;
  virtual void execute(JobContext& context) = 0;
  /// In place of execute() in a job in which the task is shed: the last output stands, with its old stamp.
  virtual void hold(JobContext& context) = 0;
  /// Gives the LET channel its memory, once, when the executive is sealed and if another group reads it.
  virtual std::uint32_t channel_words() const = 0;
  virtual void attach_channel(JobLedger& ledger, std::atomic<std::uint32_t>* words) = 0;

  void note(JobContext& context, const std::uint8_t* canonical, std::uint32_t bytes) {
    JobRecord& record = *context.record_;
    if (context.digests_) {
      const std::uint64_t digest = digest_bytes(canonical, bytes);
      record.digest[context.task_] = digest;
      chain_ = chain_digest(chain_, context.tick, digest);
    }
    keep_fields(context, canonical, bytes);
  }
  void keep_fields(JobContext& context, const std::uint8_t* canonical, std::uint32_t bytes) {
    JobRecord& record = *context.record_;
    // Once an output does not fit, none behind it is kept: offsets must follow from the table alone.
    context.record_fields_ = context.record_fields_ && record.field_bytes + bytes <= kMaxFieldBytes;
    if (context.record_fields_) {
      std::memcpy(record.fields + record.field_bytes, canonical, bytes);
      record.field_bytes += bytes;
    }
  }
  PlantedFault fault_{};

 private:
  TaskSpec spec_;
  std::uint16_t group_;
  std::uint64_t shed_{};
  std::uint64_t cut_{};
  LatencyHistogram wall_time_;
  std::uint64_t over_budget_{};
  std::uint64_t chain_{};
};

/// A task with output T. Between jobs `value()` holds the last output, for tasks of the same group.
template <Described T>
class Task : public TaskBase {
 public:
  using TaskBase::TaskBase;
  /// Output of the newest job. Only for tasks of the same group: a task that stands earlier in the table sees
  /// the value of the job before (a backward read), a later one that of this job.
  const T& value() const { return value_; }
  LetChannel<T>* const* channel() const { return &channel_; }

  std::uint32_t output_bytes() const override { return static_cast<std::uint32_t>(canonical_size<T>()); }

  void archive(Archive& archive) override {
    TaskBase::archive(archive);
    Members(archive, *this, name())
        .template base<TaskBase>()
        .fixed(channel_, channel_memory_)
        .scratch(latest_)
        .state(value_, made_by_);
  }
  void archive_channel(Archive& archive, std::uint64_t first, std::uint64_t end) override {
    if (channel_ == nullptr) return;
    for (std::uint64_t job = first; job < end; ++job) {
      T value{};
      std::uint64_t made_by = job;
      if (!channel_->ledger().still_done(job) || !channel_->read(job, value, made_by)) continue;
      archive.value(value);
      archive.value(made_by);
      if (archive.is_reading()) channel_->write(job, made_by, value);
    }
  }

  void describe(const std::uint8_t* canonical, ScalarSink sink) const override {
    T value{};
    decode_canonical(canonical, value);
    for_each_scalar(value, [&sink](const char* name, int index, auto scalar) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &scalar, sizeof(scalar));
      sink.call(sink.self, name, index, static_cast<double>(scalar), bits,
                static_cast<std::uint32_t>(sizeof(scalar)));
    });
  }

  bool poll_output(std::uint8_t* canonical) override {
    T value{};
    if (!latest_.read(value)) return false;
    encode_canonical(value, canonical);
    return true;
  }

 protected:
  virtual void run(JobContext& context, T& output) = 0;

  void execute(JobContext& context) final {
    run(context, value_);
    if (context.digests_ || context.record_fields_) {
      std::uint8_t canonical[canonical_size<T>()];
      encode_canonical(value_, canonical);
      if (fault_.armed && fault_.tick == context.tick) {
        canonical[fault_.byte % canonical_size<T>()] ^= 1u;
        decode_canonical(canonical, value_);
        fault_.armed = false;
      }
      note(context, canonical, static_cast<std::uint32_t>(canonical_size<T>()));
    }
    made_by_ = context.job;
    if (channel_ != nullptr) channel_->write(context.job, made_by_, value_);
    latest_.write(value_);
  }

  void hold(JobContext& context) final {
    if (context.record_fields_) {
      std::uint8_t canonical[canonical_size<T>()];
      encode_canonical(value_, canonical);
      keep_fields(context, canonical, static_cast<std::uint32_t>(canonical_size<T>()));
    }
    if (channel_ != nullptr) channel_->write(context.job, made_by_, value_);
  }

  std::uint32_t channel_words() const override { return LetChannel<T>::kWords; }
  void attach_channel(JobLedger& ledger, std::atomic<std::uint32_t>* words) override {
    channel_ = new (channel_memory_) LetChannel<T>(ledger, words);
  }

 private:
  T value_{};
  std::uint64_t made_by_{};
  LetChannel<T>* channel_{};
  alignas(LetChannel<T>) unsigned char channel_memory_[sizeof(LetChannel<T>)];
  Mailbox<T> latest_;
};

/// Task whose work is the callable F: `void(JobContext&, T& output)`.
template <Described T, class F>
class FunctionTask final : public Task<T> {
 public:
  FunctionTask(const TaskSpec& spec, std::uint16_t group, F function)
      : Task<T>(spec, group), function_(std::move(function)) {}

  void archive(Archive& archive) override {
    Task<T>::archive(archive);
    if constexpr (Archivable<F>) archive.value(function_);
  }
  bool hides_state() const override {
    return !Archivable<F> && !std::is_invocable_v<const F&, JobContext&, T&>;
  }

 private:
  void run(JobContext& context, T& output) override { function_(context, output); }
  F function_;
};

}  // namespace sortie::rt
