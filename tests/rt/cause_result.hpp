// SPDX-License-Identifier: BSD-3-Clause
// What is done to a worker on purpose, and what its observer has made of it.
#pragma once

#include <sys/mman.h>

#include <atomic>
#include <cstdint>
#include <new>

#include "rt/posix/delay_statistics.hpp"

namespace sortie::rt::posix::test {

/// What the rig does to its worker.
enum class Injection { none, hog, own_work, signals, queued_signals, timers, pause };

inline const char* to_string(Injection injection) {
  switch (injection) {
    case Injection::none:
      return "nothing injected";
    case Injection::hog:
      return "hog of higher priority";
    case Injection::own_work:
      return "own work beyond the budget";
    case Injection::signals:
      return "signal flood";
    case Injection::queued_signals:
      return "signals that queue up";
    case Injection::timers:
      return "timer interrupt flood";
    case Injection::pause:
      return "process paused";
  }
  return "";
}

inline DelayCause truth_of(Injection injection) {
  switch (injection) {
    case Injection::hog:
      return DelayCause::run_queue;
    case Injection::own_work:
      return DelayCause::own;
    case Injection::signals:
    case Injection::queued_signals:
    case Injection::timers:
      return DelayCause::interrupt;
    case Injection::pause:
      return DelayCause::stolen;
    case Injection::none:
      break;
  }
  return DelayCause::unknown;
}

/// One injected delay.
struct Injected {
  Nanoseconds begin_ns{};
  Nanoseconds end_ns{};
};

/// What a run of the rig has seen; lives in memory that a paused child shares with its parent.
struct RigResult {
  static constexpr std::uint32_t kMost = 20'000;
  std::atomic<std::uint32_t> injected_count{0};
  std::uint32_t outlier_count{0};
  std::uint32_t jobs{0};
  std::uint32_t skipped{0};
  char refused[200]{};
  Injected injected[kMost]{};
  DelayOutlier outliers[kMost]{};

  void inject(Nanoseconds begin, Nanoseconds end) {
    const std::uint32_t i = injected_count.load();
    if (i >= kMost) return;
    injected[i] = {begin, end};
    injected_count.store(i + 1);
  }
};

class SharedResult {
 public:
  SharedResult() {
    void* memory =
        mmap(nullptr, sizeof(RigResult), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    result_ = new (memory) RigResult;
  }
  ~SharedResult() { munmap(result_, sizeof(RigResult)); }
  SharedResult(const SharedResult&) = delete;
  SharedResult& operator=(const SharedResult&) = delete;
  RigResult* operator->() { return result_; }
  RigResult& operator*() { return *result_; }

 private:
  RigResult* result_;
};

}  // namespace sortie::rt::posix::test
