// SPDX-License-Identifier: BSD-3-Clause
// Clocks and thread set-up: what must hold on any machine, allowed or not. Nothing here depends on how fast
// it is.
#include <pthread.h>
#include <sched.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "rt/posix/clock.hpp"
#include "rt/posix/delay_observer.hpp"
#include "rt/posix/heap_trap.hpp"
#include "rt/posix/realtime.hpp"
#include "rt/posix/start_lead.hpp"

namespace sortie::rt::posix {
namespace {

// Runs `work` on a thread of its own, whose scheduling may be changed at will.
template <class Work>
void on_own_thread(Work work) {
  std::thread thread(work);
  thread.join();
}

#if defined(__SANITIZE_ADDRESS__)
// A sanitizer's shadow of the stack is memory of its own, which no run-time library of ours prefaults.
[[gnu::no_sanitize_address]]
#endif
[[gnu::noinline]] void
use_half_a_megabyte_of_stack() {
  volatile char block[512 * 1024];
  for (std::size_t i = 0; i < sizeof(block); i += 1024) block[i] = 1;
}

// Each refusal must say why in one line, and an accepted step must not.
void check_shape(const SetupResult& result) {
  CHECK(result.ok == (std::strlen(result.reason) == 0));
  CHECK(std::string(result.reason).find('\n') == std::string::npos);
}

}  // namespace

TEST_CASE("clocks run forwards and sleeping never ends too early") {
  const Nanoseconds start = monotonic_now();
  Nanoseconds last = start;
  for (int i = 0; i < 1000; ++i) {
    const Nanoseconds now = monotonic_now();
    REQUIRE(now >= last);
    last = now;
  }
  const Nanoseconds wake = monotonic_now() + 2 * kNanosecondsPerMillisecond;
  sleep_until(wake);
  CHECK(monotonic_now() >= wake);
  const Nanoseconds spun = monotonic_now() + 2 * kNanosecondsPerMillisecond;
  const auto off = std::make_unique<DelayObserver>();
  const Nanoseconds woke = wait_for_release(*off, 0, spun, 100 * kNanosecondsPerMicrosecond).woke_ns;
  CHECK(woke >= spun);
  CHECK(monotonic_now() >= woke);
  sleep_until(0);
  sleep_until(-5);
  CHECK(wait_for_release(*off, 0, start, 0).woke_ns > start);
}

TEST_CASE("the monotonic clock plus its offset is the system's UTC") {
  const Nanoseconds offset = utc_minus_monotonic();
  const Nanoseconds before = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::system_clock::now().time_since_epoch())
                                 .count();
  const Nanoseconds ours = monotonic_now() + offset;
  const Nanoseconds after = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                std::chrono::system_clock::now().time_since_epoch())
                                .count();
  CHECK(ours >= before - kNanosecondsPerMillisecond);
  CHECK(ours <= after + kNanosecondsPerMillisecond);
}

TEST_CASE("thread CPU time counts work and not sleep") {
  const Nanoseconds cpu_start = thread_cpu_now();
  const Nanoseconds start = monotonic_now();
  sleep_until(start + 20 * kNanosecondsPerMillisecond);
  const Nanoseconds slept_cpu = thread_cpu_now() - cpu_start;
  CHECK(slept_cpu < monotonic_now() - start);
  while (thread_cpu_now() - cpu_start < slept_cpu + kNanosecondsPerMillisecond) {
  }
  CHECK(thread_cpu_now() - cpu_start <= monotonic_now() - start);
}

TEST_CASE("SCHED_FIFO is set where allowed and explained where not") {
  on_own_thread([] {
    const SetupResult result = set_fifo_priority(10);
    check_shape(result);
    int policy = -1;
    sched_param parameters{};
    REQUIRE(pthread_getschedparam(pthread_self(), &policy, &parameters) == 0);
    if (result.ok) {
      CHECK(policy == SCHED_FIFO);
      CHECK(parameters.sched_priority == 10);
    } else {
      CHECK(policy == SCHED_OTHER);
      CHECK(std::string(result.reason).find("CAP_SYS_NICE") != std::string::npos);
    }
    check_shape(set_ordinary_priority());
    REQUIRE(pthread_getschedparam(pthread_self(), &policy, &parameters) == 0);
    CHECK(policy == SCHED_OTHER);
  });
  for (const int wrong : {0, -1, 100}) CHECK_FALSE(set_fifo_priority(wrong).ok);
}

TEST_CASE("a thread is bound to a core that exists and refused another") {
  CHECK(usable_cores() >= 1);
  on_own_thread([] {
    cpu_set_t set;
    REQUIRE(sched_getaffinity(0, sizeof(set), &set) == 0);
    int core = 0;
    while (CPU_ISSET(static_cast<unsigned>(core), &set) == 0) ++core;
    const SetupResult result = pin_to_core(core);
    check_shape(result);
    if (result.ok) CHECK(usable_cores() == 1);
  });
  for (const int wrong : {-1, CPU_SETSIZE - 1, CPU_SETSIZE}) {
    const SetupResult result = pin_to_core(wrong);
    CHECK_FALSE(result.ok);
    check_shape(result);
  }
}

TEST_CASE("a prefaulted stack causes no page fault when it is used, and too much is refused") {
  on_own_thread([] {
    check_shape(prefault_stack(1024 * 1024));
    static_cast<void>(thread_page_faults());  // loads the pages of the code that is measured below
    const PageFaults before = thread_page_faults();
    use_half_a_megabyte_of_stack();
    const PageFaults after = thread_page_faults();
#if defined(__SANITIZE_THREAD__) || (defined(__SANITIZE_ADDRESS__) && defined(__clang__))
    static_cast<void>(before);
    static_cast<void>(after);
    WARN("skipped: the sanitizer keeps pages of its own for the stack's");
#else
    CHECK(after.minor - before.minor <= 4);  // of 128; single pages of code and data come and go at any time
#endif
    const SetupResult absurd = prefault_stack(std::size_t{1} << 30);
    CHECK_FALSE(absurd.ok);
    check_shape(absurd);
  });
}

TEST_CASE("timer slack has limits, and names may be of any length") {
  on_own_thread([] {
    check_shape(set_timer_slack(1));
    CHECK_FALSE(set_timer_slack(0).ok);
    CHECK_FALSE(set_timer_slack(2 * kNanosecondsPerSecond).ok);
    set_thread_name("a name much longer than fifteen characters");
    char name[16]{};
    REQUIRE(pthread_getname_np(pthread_self(), name, sizeof(name)) == 0);
    CHECK(std::string(name) == "a name much lon");
  });
}

TEST_CASE("set-up steps and clocks take no heap, so that a trap may be armed around them") {
  if (!kHeapTrapAvailable) {
    WARN("skipped: this build has no heap trap");
    return;
  }
  const HeapTrapScope scope;
  static_cast<void>(monotonic_now());
  static_cast<void>(thread_cpu_now());
  static_cast<void>(utc_minus_monotonic());
  static_cast<void>(thread_page_faults());
  sleep_until(monotonic_now() + 1000);
  static_cast<void>(set_fifo_priority(0));
  const std::uint64_t calls = scope.calls();
  CHECK(calls == 0);
}

TEST_CASE("a thread's stack is as large as was asked for, and one too small is refused") {
  pthread_attr_t before;
  REQUIRE(pthread_getattr_default_np(&before) == 0);
  const SetupResult bounded = bound_thread_stacks(kThreadStackBytes);
  INFO(bounded.reason);
  REQUIRE(bounded.ok);
  std::size_t size = 0;
  std::thread probe([&size] {
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
    void* lowest = nullptr;
    pthread_attr_getstack(&attributes, &lowest, &size);
    pthread_attr_destroy(&attributes);
  });
  probe.join();
  CHECK(size == kThreadStackBytes);
  check_shape(bound_thread_stacks(1000));
  CHECK_FALSE(bound_thread_stacks(1000).ok);
  CHECK(pthread_setattr_default_np(&before) == 0);
  pthread_attr_destroy(&before);
}

TEST_CASE("the start of a run lies further ahead for more threads, and never beyond five seconds") {
  const Nanoseconds none = measure_start_lead(0, false);
  CHECK(none == 100 * kNanosecondsPerMillisecond);
  CHECK(measure_start_lead(20, true) > none);
  CHECK(measure_start_lead(1'000'000, false) == 5 * kNanosecondsPerSecond);
}

}  // namespace sortie::rt::posix
