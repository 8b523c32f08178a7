// SPDX-License-Identifier: BSD-3-Clause
// Counts the system calls of threads between two marks: runs a function in a traced child process.
#pragma once

#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace sortie::rt::posix::test {

/// A thread calls this to be counted from here on, or no longer. It is itself a system call that nothing else
/// makes, and not counted.
inline void mark_counted(bool on) { syscall(SYS_getpgid, on ? 0x50111 : 0x50110); }

/// What the marked threads of a child have called.
struct SyscallCount {
  std::string refused;                        ///< why nothing could be counted, or empty
  std::map<std::uint64_t, std::uint64_t> by;  ///< number of the call -> times, all marked threads together
  std::uint64_t threads{};                    ///< that were marked

  std::uint64_t of(long number) const {
    const auto found = by.find(static_cast<std::uint64_t>(number));
    return found == by.end() ? 0 : found->second;
  }
  std::uint64_t sleeps() const {
    std::uint64_t sum = of(SYS_clock_nanosleep);
#ifdef SYS_clock_nanosleep_time64
    sum += of(SYS_clock_nanosleep_time64);
#endif
    return sum;
  }
  std::uint64_t total() const {
    std::uint64_t sum = 0;
    for (const auto& [number, count] : by) sum += count;
    return sum;
  }
};

/// Runs `work()` in a child, stops it at each system call, and counts those of marked threads.
template <class Work>
SyscallCount watch_syscalls(Work work) {
  SyscallCount count;
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(77);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) {
    count.refused = "this process may not trace another";
    return count;
  }
  ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL);
  ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
  std::set<pid_t> counted;
  for (;;) {
    const pid_t stopped = waitpid(-1, &status, __WALL);
    if (stopped < 0) break;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (stopped != child) continue;
      if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) count.refused = "the traced child failed";
      break;
    }
    long signal = 0;
    if (WSTOPSIG(status) == (SIGTRAP | 0x80)) {
      __ptrace_syscall_info info{};
      const long got = ptrace(PTRACE_GET_SYSCALL_INFO, stopped, sizeof(info), &info);
      if (got > 0 && info.op == PTRACE_SYSCALL_INFO_ENTRY) {
        const bool mark = info.entry.nr == SYS_getpgid && (info.entry.args[0] & ~1u) == 0x50110;
        if (mark && (info.entry.args[0] & 1u) != 0) {
          counted.insert(stopped);
          ++count.threads;
        } else if (mark) {
          counted.erase(stopped);
        } else if (counted.count(stopped) != 0) {
          ++count.by[info.entry.nr];
        }
      }
    } else if (WSTOPSIG(status) != SIGTRAP && WSTOPSIG(status) != SIGSTOP) {
      signal = WSTOPSIG(status);  // the child's own affair
    }
    ptrace(PTRACE_SYSCALL, stopped, nullptr, signal);
  }
  return count;
}

}  // namespace sortie::rt::posix::test
