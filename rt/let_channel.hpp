// SPDX-License-Identifier: BSD-3-Clause
// Values that one group hands to another with logical execution time: a job's output becomes visible at its
// deadline, not when it happens to finish.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "rt/atomic_words.hpp"
#include "rt/ledger.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// When a group's jobs are released and due, in ticks. Job j: at phase + j * period, and a deadline later.
struct GroupTiming {
  std::uint32_t period{1};
  std::uint32_t phase{};
  std::uint32_t deadline{1};

  constexpr Tick release(std::uint64_t job) const { return phase + job * period; }
  constexpr Tick due(std::uint64_t job) const { return release(job) + deadline; }
  constexpr bool releases_at(Tick tick) const { return tick >= phase && (tick - phase) % period == 0; }
  constexpr std::uint64_t job_at(Tick tick) const { return (tick - phase) / period; }
  /// True when job `job` is released at `tick`. For numbers from outside, which may be anything: compare no
  /// release() with them, its product wraps at 2^64, and a wrong job then seems right.
  constexpr bool is_release(std::uint64_t job, Tick tick) const {
    return releases_at(tick) && job_at(tick) == job;
  }
  /// Newest job whose deadline is at or before `tick`, or -1.
  constexpr std::int64_t newest_due(Tick tick) const {
    const Tick first = static_cast<Tick>(phase) + deadline;
    return tick < first ? -1 : static_cast<std::int64_t>((tick - first) / period);
  }
};

/// Slots of the ring that a channel needs so that a reader that is up to one of its own deadlines late still
/// finds every value it may take. `history`: how many jobs back it reads (1 = the newest). A power of two.
constexpr std::uint32_t channel_depth(const GroupTiming& writer, const GroupTiming& reader,
                                      std::uint32_t history) {
  const std::uint32_t during = (reader.deadline + writer.period - 1) / writer.period;
  const std::uint32_t need = history + during + (writer.deadline + writer.period - 1) / writer.period + 2;
  std::uint32_t depth = 4;
  while (depth < need) depth *= 2;
  return depth;
}

/// Ring of a task's outputs by job number, guarded by the group's ledger. T is copied word by word through
/// atomics, so a reader that is overtaken sees the ledger change and never uses a torn value. One writer, any
/// number of readers. `Atomic`: as of the ledger.
template <class T, template <class> class Atomic = std::atomic>
class LetChannel {
  static_assert(std::is_trivially_copyable_v<T>, "a value that crosses groups must be plain");

 public:
  using Ledger = BasicJobLedger<Atomic>;
  /// Of a slot: the value, and the job that made it.
  static constexpr std::uint32_t kWords = kWordsOf<T> + 1;

  /// `words`: depth * kWords words that outlive the channel. `ledger`: of the writer's group.
  LetChannel(Ledger& ledger, Atomic<std::uint32_t>* words) : ledger_(&ledger), words_(words) {}

  /// Writer, between begin(job) and finish(job). `made_by`: the job that computed the value, which is an
  /// earlier one when the task was shed in this job.
  void write(std::uint64_t job, std::uint64_t made_by, const T& value) {
    // Release on every word: whoever sees a new word also sees that the ledger has left the old job.
    Atomic<std::uint32_t>* const slot = slot_of(job);
    store_words(slot, value);
    slot[kWords - 1].store(static_cast<std::uint32_t>(made_by), std::memory_order_release);
  }

  /// Reader, after decide(job) said done. False when the slot was reused meanwhile; the outputs are then
  /// unchanged. `made_by`: the job that computed the value (never behind `job`).
  bool read(std::uint64_t job, T& value, std::uint64_t& made_by) const {
    const Atomic<std::uint32_t>* const slot = slot_of(job);
    const auto raw = load_words<T>(slot);
    const std::uint32_t made = slot[kWords - 1].load(std::memory_order_acquire);
    if (!ledger_->still_done(job)) return false;
    unpack_words(raw, value);
    made_by = job - (static_cast<std::uint32_t>(job) - made);
    return true;
  }

  Ledger& ledger() const { return *ledger_; }

 private:
  Atomic<std::uint32_t>* slot_of(std::uint64_t job) const {
    return words_ + static_cast<std::size_t>(job & (ledger_->depth() - 1)) * kWords;
  }

  Ledger* ledger_;
  Atomic<std::uint32_t>* words_;
};

}  // namespace sortie::rt
