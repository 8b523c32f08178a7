// SPDX-License-Identifier: BSD-3-Clause
// What the kernel has booked for one thread: CPU time, time in the run queue, times it was switched in.
#pragma once

#include <cstdint>

#include "rt/posix/realtime.hpp"

namespace sortie::rt::posix {

/// One reading.
struct ThreadAccount {
  Nanoseconds cpu_ns{};         ///< exact right after a sleep; else up to a kernel tick behind
  Nanoseconds run_queue_ns{};   ///< ready to run, not running; exact
  std::uint64_t switched_in{};  ///< times it was put on a core; exact
};

/// /proc/thread-self/schedstat, kept open: one system call a reading (0.2 to 0.6 us).
class ThreadAccountFile {
 public:
  ThreadAccountFile() = default;
  ~ThreadAccountFile();
  ThreadAccountFile(const ThreadAccountFile&) = delete;
  ThreadAccountFile& operator=(const ThreadAccountFile&) = delete;

  /// Opens the calling thread's account; the file stays that thread's whoever reads it.
  SetupResult open_for_this_thread() noexcept;
  bool is_open() const noexcept { return file_ >= 0; }
  /// False when it cannot be read; `account` is unchanged then. Real-time safe.
  bool read(ThreadAccount& account) const noexcept;

 private:
  int file_{-1};
};

/// Times the calling thread has left its core of its own accord. About 0.2 us, a system call.
std::uint64_t voluntary_switches() noexcept;

}  // namespace sortie::rt::posix
