// SPDX-License-Identifier: BSD-3-Clause
// One verdict per job. Whether a job met its deadline is decided once, by whoever asks first after the
// deadline (the writer or a reader), and both obey. "Newest value now" would let timing into the outputs.
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/archive.hpp"
#include "rt/job_record.hpp"

namespace sortie::rt {

/// Ring of verdicts of one group's jobs. One writer (the group's worker), any number of readers. Wait-free
/// but for the writer's begin(), which retries at most once a reader. Words are 32 bits (30 of job number, 2
/// of state), so that it runs where 64-bit atomics do not exist; jobs are compared modulo 2^30, far beyond
/// any ring depth. Whoever sees "done" in decide() sees all that the writer did before finish(); no other
/// verdict brings anything along. `Atomic` is std::atomic, or its twin in the model that takes the memory
/// orders away one by one (tests/rt/ledger_model_test.cpp).
template <template <class> class Atomic = std::atomic>
class BasicJobLedger {
 public:
  /// `words`: `depth` zeroed words (a power of two) that outlive the ledger.
  BasicJobLedger(Atomic<std::uint32_t>* words, std::uint32_t depth) : words_(words), mask_(depth - 1) {
    for (std::uint32_t i = 0; i < depth; ++i)
      words_[i].store(pack(i - depth, Verdict::missed), std::memory_order_relaxed);
  }

  /// Writer: opens job `job`. False when a reader past the deadline has already called it missed.
  bool begin(std::uint64_t job) {
    Atomic<std::uint32_t>& word = at(job);
    std::uint32_t seen = word.load(std::memory_order_relaxed);
    while (!is_job(seen, job)) {
      if (word.compare_exchange_weak(seen, pack(job, Verdict::pending), std::memory_order_relaxed,
                                     std::memory_order_relaxed))
        return true;
    }
    return false;
  }

  /// Writer: closes job `job`. Returns the verdict that everybody obeys.
  Verdict finish(std::uint64_t job, bool in_time) {
    std::uint32_t expected = pack(job, Verdict::pending);
    const Verdict wanted = in_time ? Verdict::done : Verdict::missed;
    if (at(job).compare_exchange_strong(expected, pack(job, wanted), std::memory_order_release,
                                        std::memory_order_relaxed))
      return wanted;
    return Verdict::missed;
  }

  /// Reader, only after the deadline of `job`: its verdict; pending and never started jobs become missed
  /// here. A job whose word has been reused is missed as well (the reader came more than a ring too late).
  Verdict decide(std::uint64_t job) {
    Atomic<std::uint32_t>& word = at(job);
    while (true) {
      std::uint32_t seen = word.load(std::memory_order_acquire);
      if (is_job(seen, job)) {
        const auto verdict = static_cast<Verdict>(seen & 3u);
        if (verdict != Verdict::pending) return verdict;
      } else if (!is_older(seen, job)) {
        return Verdict::missed;
      }
      if (word.compare_exchange_weak(seen, pack(job, Verdict::missed), std::memory_order_relaxed,
                                     std::memory_order_relaxed))
        return Verdict::missed;
    }
  }

  /// True while `job`'s word still says done: what was loaded before, with acquire, was not overwritten. Says
  /// nothing about what is loaded afterwards.
  bool still_done(std::uint64_t job) const {
    return words_[job & mask_].load(std::memory_order_relaxed) == pack(job, Verdict::done);
  }

  /// True when `job`'s word belongs to a later job: nobody can tell any more what became of `job`.
  bool overtook(std::uint64_t job) const {
    const std::uint32_t word = words_[job & mask_].load(std::memory_order_relaxed);
    return !is_job(word, job) && !is_older(word, job);
  }

  std::uint32_t depth() const { return static_cast<std::uint32_t>(mask_ + 1); }

  /// All verdicts to bytes and back. Between jobs only.
  void archive(Archive& archive) {
    archive.expect(depth(), "the verdicts' ring has another length");
    for (std::uint64_t i = 0; i <= mask_; ++i) {
      std::uint32_t word = words_[i].load(std::memory_order_relaxed);
      archive.value(word);
      if (archive.is_reading()) words_[i].store(word, std::memory_order_relaxed);
    }
  }

 private:
  static constexpr std::uint32_t kJobMask = 0x3fffffffu;
  static constexpr std::uint32_t pack(std::uint64_t job, Verdict verdict) {
    return ((static_cast<std::uint32_t>(job) & kJobMask) << 2) | static_cast<std::uint32_t>(verdict);
  }
  static constexpr bool is_job(std::uint32_t word, std::uint64_t job) {
    return (word >> 2) == (static_cast<std::uint32_t>(job) & kJobMask);
  }
  static constexpr bool is_older(std::uint32_t word, std::uint64_t job) {
    const std::uint32_t ahead = (static_cast<std::uint32_t>(job) - (word >> 2)) & kJobMask;
    return ahead != 0 && ahead < (kJobMask >> 1);
  }
  Atomic<std::uint32_t>& at(std::uint64_t job) { return words_[job & mask_]; }

  Atomic<std::uint32_t>* words_;
  std::uint64_t mask_;
};

using JobLedger = BasicJobLedger<>;

}  // namespace sortie::rt
