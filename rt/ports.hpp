// SPDX-License-Identifier: BSD-3-Clause
// What a job reads, latched at its release: streams of samples from outside, and other groups' outputs.
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/archive.hpp"
#include "rt/job_record.hpp"
#include "rt/let_channel.hpp"
#include "rt/saturating_count.hpp"
#include "rt/spsc_ring.hpp"
#include "rt/status.hpp"

namespace sortie::rt {

/// When what a job reads counts as stale.
struct StaleRule {
  std::uint32_t after_ticks{};  ///< stale when older than so many ticks; 0: never
  bool hide{};                  ///< a stale value is not shown at all (Input::latest() is null)
};

/// How old the newest of what a job reads is.
class Freshness {
 public:
  /// Says when what comes in is stale, and of an input whether it is hidden then. Set-up only.
  void set_stale_rule(StaleRule rule) { stale_rule_ = rule; }
  /// Ticks to the job's release: of a stream since its newest sample was taken; of an input since the release
  /// of the job that made its newest value, which a shed task may only have held on to. Since the run began
  /// when there is none. The job's thread only.
  std::uint64_t age_ticks() const { return release_ - newest_; }
  /// True when that is more than the rule allows.
  bool stale() const { return stale_rule_.after_ticks != 0 && age_ticks() > stale_rule_.after_ticks; }
  /// Jobs that found it stale.
  std::uint64_t stale_jobs() const { return stale_jobs_; }

 protected:
  Tick release_{};
  Tick newest_{};
  std::uint64_t stale_jobs_{};
  StaleRule stale_rule_{};
};

/// A stream of samples from outside, as the executive sees it.
class StreamBase : public Freshness {
 public:
  StreamBase(const char* name, std::uint16_t id, std::uint32_t batch) : name_(name), id_(id), batch_(batch) {}
  virtual ~StreamBase() = default;

  const char* name() const { return name_; }
  std::uint16_t id() const { return id_; }
  /// Most samples that one job takes; the rest waits for the next release.
  std::uint32_t batch() const { return batch_; }
  /// Samples that wait now.
  virtual std::uint32_t waiting() const = 0;
  /// Samples refused: the ring was full, or no log could hold them; stays at 4,294,967,295. Any thread.
  std::uint32_t refused() const { return refused_.value(); }
  /// Most samples that ever waited at a release.
  std::uint32_t high_water() const { return high_water_.load(std::memory_order_relaxed); }
  virtual std::uint32_t capacity() const = 0;
  /// Number of the next sample that is admitted. When no job runs and nobody pushes.
  std::uint64_t next_admitted() const { return next_ + waiting(); }

  /// Executive: takes up to `limit` samples for the job released at `release` and writes the range down.
  void latch(Tick release, std::uint32_t limit, StreamRange& range) {
    const std::uint32_t there = waiting();
    if (there > high_water_.load(std::memory_order_relaxed))
      high_water_.store(there, std::memory_order_relaxed);
    std::uint32_t wanted = limit < batch_ ? limit : batch_;
    if (there < wanted) wanted = there;
    range = {next_, take(wanted), id_};
    next_ += range.count;
    release_ = release;
    if (range.count != 0) newest_ = release;
    stale_jobs_ += stale() ? 1u : 0u;
  }

  /// Sequence numbers, counters and the samples that wait, to bytes and back. Between jobs only, with nobody
  /// pushing. The batch of the last job is no state: the next job's is taken before its first task runs.
  virtual void archive(Archive& archive) {
    archive.expect(capacity(), "a stream has another capacity");
    Members(archive, *this, name_)
        .fixed(name_, id_, batch_, stale_rule_)
        .by_hand(refused_, high_water_)
        .state(next_, release_, newest_, stale_jobs_);
    std::uint32_t high_water = high_water_.load(std::memory_order_relaxed);
    std::uint64_t refused = refused_.value();
    archive.value(high_water);
    archive.value(refused);
    high_water_.store(high_water, std::memory_order_relaxed);
    refused_.set(refused);
  }

 protected:
  virtual std::uint32_t take(std::uint32_t count) = 0;
  SaturatingCount refused_;  // raised by the producer only

 private:
  const char* name_;
  std::uint64_t next_{};
  std::atomic<std::uint32_t> high_water_{};
  std::uint16_t id_;
  std::uint32_t batch_;
};

/// Stream of plain samples: one producer thread pushes, one group consumes. Its memory is given, no heap.
template <class T>
class Stream final : public StreamBase {
 public:
  /// `ring`: capacity slots (a power of two); `batch`: batch_size slots. Both outlive the stream.
  Stream(const char* name, std::uint16_t id, T* ring, std::uint32_t capacity, T* batch,
         std::uint32_t batch_size)
      : StreamBase(name, id, batch_size), ring_(ring, capacity), batch_(batch) {}

  /// Producer: admits one sample. Status: ok, or full (refused and counted; nothing changed).
  Status push(const T& sample) { return ring_.try_push(sample) ? Status::ok : refuse(); }
  /// Producer: true means that the next push() will be admitted; only the producer can take the room away.
  bool has_room() const { return ring_.size() < ring_.capacity(); }
  /// Producer: refuses a sample without looking for room. Always full; counted.
  Status refuse() {
    refused_.add();
    return Status::full;
  }

  /// The samples of the current job, oldest first.
  const T* begin() const { return batch_; }
  const T* end() const { return batch_ + taken_; }
  std::uint32_t size() const { return taken_; }

  std::uint32_t waiting() const override { return ring_.size(); }
  std::uint32_t capacity() const override { return ring_.capacity(); }

  void archive(Archive& archive) override {
    StreamBase::archive(archive);
    std::uint32_t count = ring_.size();
    T sample{};
    // Samples go round once: out at the front, in again behind.
    for (std::uint32_t i = 0; archive.is_reading() && i < count; ++i)
      static_cast<void>(ring_.try_pop(sample));
    archive.bounded(count, ring_.capacity());
    if (count != 0 && !Archivable<T>) archive.fail(Status::not_supported, "samples without a list of fields");
    for (std::uint32_t i = 0; i < count; ++i) {
      sample = T{};
      if (!archive.is_reading()) static_cast<void>(ring_.try_pop(sample));
      if constexpr (Archivable<T>) archive.value(sample);
      static_cast<void>(ring_.try_push(sample));
    }
    if (archive.is_reading()) taken_ = 0;
  }

 private:
  std::uint32_t take(std::uint32_t count) override { return taken_ = ring_.pop_n(batch_, count); }

  SpscSpanRing<T> ring_;
  T* batch_;
  std::uint32_t taken_{};
};

/// Another group's output, as the executive sees it.
class InputBase : public Freshness {
 public:
  InputBase(std::uint16_t writer_group, std::uint16_t task, std::uint32_t history)
      : writer_group_(writer_group), task_(task), history_(history) {}
  virtual ~InputBase() = default;

  std::uint16_t writer_group() const { return writer_group_; }
  std::uint16_t task() const { return task_; }
  std::uint32_t history() const { return history_; }

  /// Executive: takes what is visible at `release`. `forced`: the range that a recorded job took, or null.
  void latch(const GroupTiming& writer, Tick release, const InputRange* forced, InputRange& range) {
    const std::int64_t newest = writer.newest_due(release);
    std::int64_t oldest = newest - static_cast<std::int64_t>(history_) + 1;
    if (oldest <= considered_) oldest = considered_ + 1;
    if (oldest < 0) oldest = 0;
    std::int64_t last = newest;
    if (forced != nullptr) {
      oldest = forced->first > oldest ? forced->first : oldest;
      last = forced->last < newest ? forced->last : newest;  // a damaged record may ask for more
    }
    considered_ = newest > considered_ ? newest : considered_;
    range = collect(oldest, last);
    release_ = release;
    if (newest_made_ >= 0) newest_ = writer.release(static_cast<std::uint64_t>(newest_made_));
    stale_jobs_ += stale() ? 1u : 0u;
  }

  /// Newest of the writer's jobs that was offered, taken or not; nobody asks for it or an older one again.
  std::int64_t considered() const { return considered_; }
  /// What was seen so far, to bytes and back. Between jobs only.
  virtual void archive(Archive& archive) {
    Members(archive, *this, "an input")
        .fixed(writer_group_, task_, history_, stale_rule_)
        .state(considered_, newest_made_, release_, newest_, stale_jobs_);
    if (considered_ < -1 || considered_ > (std::int64_t{1} << 62)) {
      considered_ = -1;
      archive.fail(Status::malformed, "an input has seen a job that cannot be");
    }
  }

 protected:
  virtual InputRange collect(std::int64_t oldest, std::int64_t newest) = 0;
  bool hidden() const { return stale_rule_.hide && stale(); }
  std::int64_t newest_made_{-1};  // job that made the newest value taken

 private:
  std::uint16_t writer_group_;
  std::uint16_t task_;
  std::uint32_t history_;
  std::int64_t considered_{-1};
};

/// Values of type T from another group. `latest()` stays the last one taken when nothing new is visible.
template <class T>
class Input final : public InputBase {
 public:
  /// `values`: `history` slots that outlive the input. `channel`: address of the writer task's channel
  /// pointer, which is set when the executive is sealed.
  Input(std::uint16_t writer_group, std::uint16_t task, std::uint32_t history, T* values,
        LetChannel<T>* const* channel)
      : InputBase(writer_group, task, history), values_(values), channel_(channel) {}

  /// New values of this job, oldest first; empty when none became visible since the job before. What a shed
  /// task only held on to is not new.
  const T* begin() const { return values_; }
  const T* end() const { return values_ + taken_; }
  std::uint32_t size() const { return taken_; }
  /// Newest value ever taken, or null before the first and when the rule hides a stale one.
  const T* latest() const { return newest_made_ >= 0 && !hidden() ? &latest_ : nullptr; }
  /// Number of the writer's job that made the newest value, or -1.
  std::int64_t latest_job() const { return newest_made_; }

  void archive(Archive& archive) override {
    InputBase::archive(archive);
    Members(archive, *this, "an input")
        .template base<InputBase>()
        .fixed(values_, channel_)
        .scratch(taken_)
        .state(latest_);
    if (archive.is_reading()) taken_ = 0;
  }

 private:
  InputRange collect(std::int64_t oldest, std::int64_t newest) override {
    taken_ = 0;
    InputRange range{};
    std::int64_t newest_made = -1;
    for (std::int64_t job = oldest; job <= newest; ++job) {
      const auto number = static_cast<std::uint64_t>(job);
      const bool done = (*channel_)->ledger().decide(number) == Verdict::done;
      std::uint64_t made_by = 0;
      if (done ? !(*channel_)->read(number, values_[taken_], made_by)
               : (*channel_)->ledger().overtook(number)) {
        // Overtaken by the writer, whose record may say done: keep what comes after the hole, as one range.
        taken_ = 0;
        newest_made = -1;
        range = InputRange{};
        continue;
      }
      if (!done) continue;
      if (range.last < 0) range.first = job;
      range.last = job;
      if (made_by != number) continue;
      ++taken_;
      newest_made = job;
    }
    if (taken_ > 0) {
      latest_ = values_[taken_ - 1];
      newest_made_ = newest_made;
    }
    return range;
  }

  T* values_;
  LetChannel<T>* const* channel_;
  std::uint32_t taken_{};
  T latest_{};
};

}  // namespace sortie::rt
