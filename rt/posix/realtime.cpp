// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/realtime.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace sortie::rt::posix {

SetupResult refusal(const char* format, ...) noexcept {
  SetupResult result;
  result.ok = false;
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(result.reason, sizeof(result.reason), format, arguments);
  va_end(arguments);
  return result;
}

namespace {

SetupResult set_scheduler(int policy, int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), policy, &parameters);
  if (error == 0) return {};
  return refusal(
      "SCHED_FIFO priority %d: %s; run as root, grant CAP_SYS_NICE, or raise 'rtprio' in limits.conf",
      priority, std::strerror(error));
}

}  // namespace

SetupResult set_fifo_priority(int priority) noexcept {
  if (priority < 1 || priority > 99) return refusal("SCHED_FIFO priority %d: must be 1 to 99", priority);
  return set_scheduler(SCHED_FIFO, priority);
}

SetupResult set_ordinary_priority() noexcept { return set_scheduler(SCHED_OTHER, 0); }

int thread_number() noexcept { return static_cast<int>(::syscall(SYS_gettid)); }

SetupResult take_priority_from(int thread) noexcept {
  const sched_param none{};
  if (::sched_setscheduler(thread, SCHED_OTHER, &none) == 0) return {};
  return refusal("SCHED_OTHER for thread %d: %s", thread, std::strerror(errno));
}

SetupResult lock_memory() noexcept {
#ifdef __GLIBC__
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
#endif
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return refusal("mlockall: %s; run as root, grant CAP_IPC_LOCK, or raise 'memlock' in limits.conf",
                 std::strerror(errno));
}

SetupResult bound_thread_stacks(std::size_t bytes) noexcept {
  if (bytes < std::size_t{64} * 1024) return refusal("stacks of %zu bytes: 65536 at least", bytes);
#ifdef __GLIBC__
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return refusal("stacks: their size is not known");
  pthread_attr_setstacksize(&attributes, bytes);
  const int error = pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
  if (error == 0) return {};
  return refusal("stacks of %zu bytes: %s", bytes, std::strerror(error));
#else
  return refusal("stacks of %zu bytes: this C library cannot; set 'ulimit -s'", bytes);
#endif
}

SetupResult pin_to_core(int core) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (core < 0 || core >= CPU_SETSIZE) return refusal("core %d: there is no such core", core);
  CPU_SET(static_cast<unsigned>(core), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
  if (error == 0) return {};
  return refusal("core %d: %s; this process may use %d core(s)", core, std::strerror(error), usable_cores());
}

int usable_cores() noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
  const int cores = CPU_COUNT(&set);
  return cores > 0 ? cores : 1;
}

SetupResult prefault_stack(std::size_t bytes) noexcept {
  pthread_attr_t attributes;
  void* lowest = nullptr;
  std::size_t size = 0;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return refusal("stack: its bounds are not known");
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);

  // Not the address of a local: a sanitizer may keep those elsewhere.
  const auto top = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const auto bottom = reinterpret_cast<std::uintptr_t>(lowest);
  constexpr std::size_t kReserve = std::size_t{64} * 1024;
  const std::size_t left = top > bottom ? static_cast<std::size_t>(top - bottom) : 0;
  if (left < kReserve || bytes > left - kReserve) {
    return refusal("stack: %zu bytes wanted, %zu left; ask for less or raise 'ulimit -s'", bytes, left);
  }
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  // Walks down page by page, as deep calls would: the kernel grows the main thread's stack on touch.
  for (std::size_t depth = page; depth <= bytes; depth += page) {
    *reinterpret_cast<volatile char*>(top - depth) = 0;  // NOLINT(performance-no-int-to-ptr)
  }
  return {};
}

SetupResult set_timer_slack(Nanoseconds slack_ns) noexcept {
  if (slack_ns < 1 || slack_ns > kNanosecondsPerSecond) return refusal("timer slack: must be 1 ns to 1 s");
  if (prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_ns), 0, 0, 0) == 0) return {};
  return refusal("timer slack: %s", std::strerror(errno));
}

void set_thread_name(const char* name) noexcept {
  char cut[16]{};
  std::strncpy(cut, name, sizeof(cut) - 1);
  pthread_setname_np(pthread_self(), cut);
}

PageFaults thread_page_faults() noexcept {
  rusage usage{};
  if (getrusage(RUSAGE_THREAD, &usage) != 0) return {};
  return {usage.ru_minflt, usage.ru_majflt};
}

}  // namespace sortie::rt::posix
