// SPDX-License-Identifier: BSD-3-Clause
// Runs two or three small threads in every possible interleaving, one after another, as fibres of one real
// thread.
#pragma once

#include <ucontext.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

/// Ends a test where fibres do not work.
#if defined(__SANITIZE_THREAD__)
#define SORTIE_NO_FIBRES 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SORTIE_NO_FIBRES 1
#endif
#endif
#ifdef SORTIE_NO_FIBRES
#define SORTIE_SKIP_WITHOUT_FIBRES()                                  \
  WARN("skipped: ThreadSanitizer does not follow ucontext switches"); \
  return
#else
#define SORTIE_SKIP_WITHOUT_FIBRES() static_cast<void>(0)
#endif

namespace sortie::rt::test {

/// What an exploration came to.
struct Result {
  std::uint64_t executions;
  std::uint64_t failures;
};
inline Result operator+(const Result& a, const Result& b) {
  return {a.executions + b.executions, a.failures + b.failures};
}

inline constexpr int kThreads = 3;   // at most
inline constexpr int kOutside = -1;  // code before the threads start and after all have ended

using Clock = std::array<std::uint32_t, kThreads>;

inline void join(Clock& into, const Clock& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = into[i] < other[i] ? other[i] : into[i];
}

/// Depth-first walk over all choices of all executions, and the fibres that make the choices.
class Explorer {
 public:
  static Explorer& instance() {
    static Explorer explorer;
    return explorer;
  }

  /// Runs `setup`, then both bodies interleaved, then `check`, once for every interleaving. Returns the
  /// number of executions; ends at the first failure when `stop_at_failure` is set.
  std::uint64_t explore(const std::function<void()>& setup, const std::function<void()>& first,
                        const std::function<void()>& second, const std::function<void()>& check,
                        bool stop_at_failure) {
    return explore(setup, std::vector<std::function<void()>>{first, second}, check, stop_at_failure);
  }

  /// The same with two or three bodies.
  std::uint64_t explore(const std::function<void()>& setup, const std::vector<std::function<void()>>& bodies,
                        const std::function<void()>& check, bool stop_at_failure) {
    bodies_ = &bodies;
    choices_.clear();
    failures_ = 0;
    std::uint64_t executions = 0;
    do {
      position_ = 0;
      current_ = kOutside;
      clocks_ = {};
      setup();
      run();
      current_ = kOutside;
      check();
      ++executions;
      if (stop_at_failure && failures_ != 0) break;
    } while (next_execution());
    return executions;
  }

  /// Called by instrumented code: another thread may run now.
  void yield() {
    if (current_ == kOutside) return;
    const std::uint32_t pick = choose(1 + others());
    if (pick == 0) return;
    const int from = current_;
    current_ = other(pick - 1);
    swapcontext(&fibres_[static_cast<std::size_t>(from)], &fibres_[static_cast<std::size_t>(current_)]);
  }

  /// One of `count` possibilities; all are tried in the end.
  std::uint32_t choose(std::uint32_t count) {
    if (count <= 1) return 0;
    if (position_ == choices_.size()) choices_.push_back({0, count});
    return choices_[position_++].taken;
  }

  void fail() { ++failures_; }
  std::uint64_t failures() const { return failures_; }
  int current() const { return current_; }

  /// The running thread's knowledge of all threads' steps; outside, everything is known.
  Clock clock() const {
    if (current_ != kOutside) return clocks_[static_cast<std::size_t>(current_)];
    Clock all;
    all.fill(UINT32_MAX);
    return all;
  }
  void learn(const Clock& other) {
    if (current_ != kOutside) join(clocks_[static_cast<std::size_t>(current_)], other);
  }
  /// Counts a step of the running thread; returns its number.
  std::uint32_t step() {
    if (current_ == kOutside) return 0;
    const auto thread = static_cast<std::size_t>(current_);
    return ++clocks_[thread][thread];
  }

 private:
  struct Choice {
    std::uint32_t taken;
    std::uint32_t count;
  };

  // Threads that have not ended, the running one apart.
  std::uint32_t others() const {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < bodies_->size(); ++i) {
      if (!finished_[i] && static_cast<int>(i) != current_) ++count;
    }
    return count;
  }
  int other(std::uint32_t number) const {
    for (std::size_t i = 0;; ++i) {
      if (!finished_[i] && static_cast<int>(i) != current_ && number-- == 0) return static_cast<int>(i);
    }
  }

  static void entry() {
    Explorer& self = instance();
    const auto thread = static_cast<std::size_t>(self.current_);
    (*self.bodies_)[thread]();
    self.finished_[thread] = true;
    const std::uint32_t left = self.others();
    if (left == 0) {
      setcontext(&self.main_);
    } else {
      self.current_ = self.other(self.choose(left));
      setcontext(&self.fibres_[static_cast<std::size_t>(self.current_)]);
    }
  }

  void prepare(std::size_t thread) {
    stacks_[thread].resize(256 * 1024);
    getcontext(&fibres_[thread]);
    fibres_[thread].uc_stack.ss_sp = stacks_[thread].data();
    fibres_[thread].uc_stack.ss_size = stacks_[thread].size();
    fibres_[thread].uc_link = nullptr;
    makecontext(&fibres_[thread], &Explorer::entry, 0);
  }

  void run() {
    finished_ = {};
    for (std::size_t thread = 0; thread < bodies_->size(); ++thread) prepare(thread);
    current_ = static_cast<int>(choose(static_cast<std::uint32_t>(bodies_->size())));
    swapcontext(&main_, &fibres_[static_cast<std::size_t>(current_)]);
  }

  bool next_execution() {
    while (!choices_.empty() && choices_.back().taken + 1 == choices_.back().count) choices_.pop_back();
    if (choices_.empty()) return false;
    ++choices_.back().taken;
    return true;
  }

  std::vector<Choice> choices_;
  std::size_t position_{0};
  std::uint64_t failures_{0};
  int current_{kOutside};
  std::array<Clock, kThreads> clocks_{};
  const std::vector<std::function<void()>>* bodies_{nullptr};
  std::array<bool, kThreads> finished_{};
  std::array<std::vector<char>, kThreads> stacks_;
  std::array<ucontext_t, kThreads> fibres_{};
  ucontext_t main_{};
};

}  // namespace sortie::rt::test
