// SPDX-License-Identifier: BSD-3-Clause
// The way out of a job for what moves something: commands to drives, flippers, rotors, sensors.
//
// The rule, for every command of every vehicle: it leaves at the deadline of the job that made it, if that
// job met the deadline; a late one is dropped and counted. The executive keeps it, not the task: a task only
// stages a value, and the verdict of its group's ledger, which other groups obey too, decides. The one
// exception is a stop: a late one leaves as soon as its job has ended, because nothing is safer than to obey
// it. Of several the newest counts; none waits in a queue, so none is refused for want of room.
// What only shows something (telemetry, reports) takes no part: it shows late outputs too.
#pragma once

#include <atomic>
#include <cstdint>
#include <new>

#include "rt/archive.hpp"
#include "rt/let_channel.hpp"
#include "rt/mailbox.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// When a stop is a stop is said where its type is: `bool stops(const T&)`. Types without have no stop.
template <class T>
bool is_stop(const T& value) {
  if constexpr (requires { stops(value); }) {
    return stops(value);
  } else {
    return false;
  }
}

/// An outlet, as the executive sees it.
class CommandOutletBase {
 public:
  virtual ~CommandOutletBase() = default;
  /// Commands of late jobs that were dropped; and stops of late jobs, which left all the same. Both follow
  /// from the verdicts, so a replay counts the same. When no job runs.
  std::uint64_t late() const { return late_; }
  std::uint64_t late_stops() const { return late_stops_; }

  /// Words of channel memory for each job of the group's ledger.
  virtual std::uint32_t channel_words() const = 0;
  /// Executive, once when it is sealed. `words`: channel_words() for each job in the ledger's ring.
  virtual void attach(JobLedger& ledger, const GroupTiming& timing, std::atomic<std::uint32_t>* words) = 0;
  /// Executive: no task of the job runs any more; before its verdict.
  virtual void close(std::uint64_t job) = 0;
  /// Executive: the job's verdict.
  virtual void settle(std::uint64_t job, Verdict verdict) = 0;

  /// The counts to bytes and back. What waits is not state: a replay commands nothing.
  void archive(Archive& archive) {
    archive.value(late_);
    archive.value(late_stops_);
  }

 protected:
  std::uint64_t late_{};
  std::uint64_t late_stops_{};
};

/// Way out for values of type T, from one group to one thread that does input and output. Wait-free for the
/// job; no heap. The last value that a job puts counts.
template <class T>
class CommandOutlet final : public CommandOutletBase {
 public:
  CommandOutlet(Nanoseconds base_tick_ns, Nanoseconds epoch_ns)
      : base_tick_ns_(base_tick_ns), epoch_ns_(epoch_ns) {}

  /// Task: stages the job's command.
  void put(const T& value) { staged_ = {value, 1u}; }

  /// I/O thread: takes the newest command that may leave at `now_ns` of the run's clock, if there is one that
  /// is newer than the one taken before. Looks at no more jobs than the ledger holds.
  bool take(Nanoseconds now_ns, T& value) {
    const bool found = take_in_time(now_ns, value);
    if (!stops_.refresh()) return found;
    const LateStop& stop = stops_.value();
    if (static_cast<std::int64_t>(stop.job) <= taken_) return found;  // a newer command has left
    taken_ = static_cast<std::int64_t>(stop.job);
    value = stop.value;
    return true;
  }

  std::uint32_t channel_words() const override { return LetChannel<Staged>::kWords; }
  void attach(JobLedger& ledger, const GroupTiming& timing, std::atomic<std::uint32_t>* words) override {
    timing_ = timing;
    channel_ = new (channel_memory_) LetChannel<Staged>(ledger, words);
  }
  void close(std::uint64_t job) override { channel_->write(job, job, staged_); }
  void settle(std::uint64_t job, Verdict verdict) override {
    if (staged_.is_there != 0 && verdict == Verdict::missed) {
      if (is_stop(staged_.value)) {
        stops_.write({job, staged_.value});
        ++late_stops_;
      } else {
        ++late_;
      }
    }
    staged_.is_there = 0;
  }

 private:
  struct Staged {
    T value{};
    std::uint32_t is_there{};
  };
  struct LateStop {
    std::uint64_t job{};
    T value{};
  };

  // The newest first; one that was overtaken by the writer meanwhile has a newer one behind it.
  bool take_in_time(Nanoseconds now_ns, T& value) {
    if (channel_ == nullptr || now_ns < epoch_ns_) return false;
    const std::int64_t newest = timing_.newest_due(static_cast<Tick>((now_ns - epoch_ns_) / base_tick_ns_));
    const std::int64_t oldest = newest - channel_->ledger().depth();
    Staged staged;
    for (std::int64_t job = newest; job > looked_ && job > oldest && job >= 0; --job) {
      const auto number = static_cast<std::uint64_t>(job);
      std::uint64_t made_by = 0;
      if (channel_->ledger().decide(number) != Verdict::done) continue;
      if (!channel_->read(number, staged, made_by) || staged.is_there == 0) continue;
      looked_ = newest;
      if (job <= taken_) return false;
      taken_ = job;
      value = staged.value;
      return true;
    }
    looked_ = newest > looked_ ? newest : looked_;
    return false;
  }

  Nanoseconds base_tick_ns_;
  Nanoseconds epoch_ns_;
  GroupTiming timing_{};
  LetChannel<Staged>* channel_{};
  alignas(LetChannel<Staged>) unsigned char channel_memory_[sizeof(LetChannel<Staged>)];
  Staged staged_{};          // the job's
  Mailbox<LateStop> stops_;  // from the job to the I/O thread
  // The I/O thread's:
  std::int64_t looked_{-1};  // newest job that was asked for
  std::int64_t taken_{-1};   // job of the newest command taken
};

}  // namespace sortie::rt
