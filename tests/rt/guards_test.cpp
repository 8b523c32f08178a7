// SPDX-License-Identifier: BSD-3-Clause
// After start-up a worker makes one system call a tick, two where causes of delays are looked for, and no
// page fault. Each guard is shown to notice one too many.
#include <sys/mman.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "rt/posix/clock.hpp"
#include "rt/posix/delay_observer.hpp"
#include "rt/posix/live_runner.hpp"
#include "tests/rt/emulated.hpp"
#include "tests/rt/executive_rig.hpp"
#include "tests/rt/syscall_watch.hpp"

namespace sortie::rt::posix::test {
namespace {

using rt::test::Sum;

constexpr Tick kTicks = 1000;
constexpr Nanoseconds kTickNs = 2 * kNanosecondsPerMillisecond;

// What a child tells its parent.
struct Shared {
  std::uint64_t jobs{};
  std::uint64_t skipped{};
  long minor_faults{};
  long major_faults{};
  bool refused{};
};

class SharedMemory {
 public:
  SharedMemory()
      : memory_(mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ != MAP_FAILED) new (memory_) Shared;
  }
  ~SharedMemory() { munmap(memory_, sizeof(Shared)); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  Shared& operator*() { return *static_cast<Shared*>(memory_); }
  Shared* operator->() { return static_cast<Shared*>(memory_); }

 private:
  void* memory_;
};

// A live run of one group with one task whose job is `job(tick)`.
template <class Job>
void run_live(Shared& shared, bool realtime, bool attribution, Job job) {
  std::vector<std::byte> memory(4u << 20);
  Arena arena(memory);
  Executive executive(arena, kTickNs, 0);
  const GroupId group = executive.add_group({"guarded", 1, 0, -1});
  executive.add_task<Sum>(group, "task", 1000, [&](JobContext& context, Sum& sum) {
    job(context.tick);
    sum.job = context.job;
  });
  if (executive.seal() != Status::ok) _exit(3);
  LiveOptions options;
  options.realtime = realtime;
  options.attribution = attribution;
  options.delay_threshold_ns =
      3600 * kNanosecondsPerSecond;  // a late job costs three more, and tracing makes late
  options.start_ns = monotonic_now() + 50 * kNanosecondsPerMillisecond;
  options.last_tick = kTicks - 1;
  options.on_worker = [](bool starts) { mark_counted(starts); };
  static Nanoseconds start;
  start = options.start_ns;
  executive.set_clock([](void*) { return monotonic_now() - start; }, nullptr);
  LiveRunner runner(executive, options);
  runner.start();
  runner.join();
  shared.jobs = executive.group(0).jobs;
  shared.skipped = executive.group(0).skipped;
  shared.refused = runner.refused();
}

// Why nothing can be counted here, or empty.
std::string uncountable() {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  return "a sanitizer makes calls and faults of its own";
#else
  return emulated() ? "an emulator makes calls and faults of its own" : "";
#endif
}

}  // namespace

TEST_CASE("a live worker makes exactly one system call a tick and it is the sleep") {
  SharedMemory shared;
  const SyscallCount count = uncountable().empty()
                                 ? watch_syscalls([&] { run_live(*shared, true, false, [](Tick) {}); })
                                 : SyscallCount{uncountable(), {}, 0};
  if (!count.refused.empty()) {
    WARN("skipped: " << count.refused);
    return;
  }
  const std::uint64_t sleeps = count.sleeps();
  INFO(sleeps << " sleeps of " << count.total() << " calls, " << shared->jobs << " jobs, " << shared->skipped
              << " skipped");
  CHECK(count.threads == 1);
  CHECK(count.total() == sleeps);
  CHECK(sleeps <= kTicks);
  CHECK(shared->jobs + shared->skipped == kTicks);
  CHECK(sleeps * 10 > kTicks);  // a late release has no time to sleep: fewer calls, never more
}

TEST_CASE("a system call in a task is noticed") {
  SharedMemory shared;
  const SyscallCount count =
      uncountable().empty()
          ? watch_syscalls([&] { run_live(*shared, false, false, [](Tick) { syscall(SYS_getppid); }); })
          : SyscallCount{uncountable(), {}, 0};
  if (!count.refused.empty()) {
    WARN("skipped: " << count.refused);
    return;
  }
  CHECK(count.of(SYS_getppid) == shared->jobs);
  CHECK(count.total() > count.sleeps());
}

TEST_CASE("attribution costs exactly one more system call a tick") {
  SharedMemory shared;
  const SyscallCount count = uncountable().empty()
                                 ? watch_syscalls([&] { run_live(*shared, true, true, [](Tick) {}); })
                                 : SyscallCount{uncountable(), {}, 0};
  if (!count.refused.empty()) {
    WARN("skipped: " << count.refused);
    return;
  }
  const std::uint64_t sleeps = count.sleeps();
  INFO(sleeps << " sleeps of " << count.total() << " calls");
  CHECK(count.of(SYS_pread64) == sleeps);
  CHECK(count.total() == 2 * sleeps);
  CHECK(sleeps <= kTicks);
  CHECK(sleeps * 10 > kTicks);
}

TEST_CASE("an observer that is off makes no system call and keeps no statistics") {
  const SyscallCount count = uncountable().empty() ? watch_syscalls([&] {
    const auto observer = std::make_unique<DelayObserver>();
    mark_counted(true);
    const Nanoseconds start = monotonic_now();
    for (Tick tick = 0; tick < 100; ++tick) {
      static_cast<void>(wait_for_release(*observer, tick, start, 50'000));  // past: there is no sleep either
      observer->after_job(tick, start, monotonic_now(), 1);
    }
    observer->finish();
    mark_counted(false);
    if (observer->statistics().start.raw.count() != 0) _exit(5);
  })
                                                   : SyscallCount{uncountable(), {}, 0};
  if (!count.refused.empty()) {
    WARN("skipped: " << count.refused);
    return;
  }
  CHECK(count.threads == 1);
  CHECK(count.total() == 0);
}

namespace {

// Page faults of a live worker between its tenth and its last job, in a child whose memory is locked.
template <class Job>
void count_faults(Shared& shared, Job job) {
  const pid_t child = fork();
  if (child == 0) {
    PageFaults first;
    run_live(shared, true, true, [&](Tick tick) {
      if (tick <= 10) first = thread_page_faults();
      job(tick);
      const PageFaults now = thread_page_faults();
      shared.minor_faults = now.minor - first.minor;
      shared.major_faults = now.major - first.major;
    });
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  shared.refused = shared.refused || !WIFEXITED(status) || WEXITSTATUS(status) != 0;
}

}  // namespace

TEST_CASE("a live worker makes no page fault after start-up") {
  SharedMemory shared;
  if (uncountable().empty()) count_faults(*shared, [](Tick) {});
  if (!uncountable().empty() || shared->refused) {
    WARN("skipped: " << (uncountable().empty() ? "the platform refuses locked memory or SCHED_FIFO"
                                               : uncountable()));
    return;
  }
  CHECK(shared->jobs > 20);
  CHECK(shared->minor_faults == 0);
  CHECK(shared->major_faults == 0);
}

TEST_CASE("a page fault in a task is noticed") {
  SharedMemory shared;
  if (uncountable().empty()) {
    count_faults(*shared, [](Tick tick) {
      // Memory that is neither locked nor there: one page a job.
      constexpr std::size_t kPage = 4096;
      static char* const pages = [] {
        void* memory =
            mmap(nullptr, kTicks * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        munlock(memory, kTicks * kPage);
        madvise(memory, kTicks * kPage, MADV_NOHUGEPAGE);
        madvise(memory, kTicks * kPage, MADV_DONTNEED);
        return static_cast<char*>(memory);
      }();
      pages[static_cast<std::size_t>(tick % kTicks) * kPage] = 1;
    });
  }
  if (!uncountable().empty() || shared->refused) {
    WARN("skipped: " << (uncountable().empty() ? "the platform refuses locked memory or SCHED_FIFO"
                                               : uncountable()));
    return;
  }
  CHECK(shared->minor_faults + 20 >= static_cast<long>(shared->jobs));
}

}  // namespace sortie::rt::posix::test
