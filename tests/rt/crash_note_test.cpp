// SPDX-License-Identifier: BSD-3-Clause
// A process that dies of a signal says so in its flight ring, and dies of it as it would have without.
#include "rt/posix/crash_note.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "tests/rt/flight_ring_rig.hpp"

namespace sortie::rt::posix {

using namespace test;

namespace {

// What a child dies of that does `act` while its ring hears signals.
template <class Act>
int death_of(const std::string& path, Act act) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS})
      signal(number, SIG_DFL);  // not the test's own
    FlightRing ring(path, plan_of_two());
    const CrashNote note(ring);
    ring.job(job_of(0, 41));
    act(ring);
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_CASE("a fault is noted with its address and thread, and is still the death of the process") {
  const RingFolder folder;
  const int death = death_of(folder.file(), [](FlightRing& ring) {
    std::thread worker([&ring] {
      ring.job(job_of(1, 0));  // this thread's track is the slow group's
      void* volatile nowhere = reinterpret_cast<void*>(std::uintptr_t{64});
      *static_cast<volatile int*>(nowhere) = 1;
    });
    worker.join();
  });
  CHECK(death == SIGSEGV);
  const FlightReader reader(folder.file());
  CHECK_FALSE(reader.ended());
  CHECK(reader.state().signal == SIGSEGV);
  CHECK(reader.state().signal_code > 0);
  CHECK(reader.state().signal_address == 64);
  CHECK(reader.state().signal_track == 2);
  CHECK(reader.state().signal_ns > 0);
  CHECK(reader.jobs().size() == 2);
}

TEST_CASE("abort, and a signal that was sent, are told apart from a fault, and SIGKILL leaves no note") {
  const RingFolder folder;
  CHECK(death_of(folder.file("a"), [](FlightRing&) { std::abort(); }) == SIGABRT);
  CHECK(FlightReader(folder.file("a")).state().signal == SIGABRT);
  CHECK(FlightReader(folder.file("a")).state().signal_code == SI_TKILL);
  CHECK(death_of(folder.file("b"), [](FlightRing&) { kill(getpid(), SIGFPE); }) == SIGFPE);
  CHECK(FlightReader(folder.file("b")).state().signal == SIGFPE);
  CHECK(FlightReader(folder.file("b")).state().signal_code == SI_USER);
  CHECK(death_of(folder.file("c"), [](FlightRing&) { raise(SIGKILL); }) == SIGKILL);
  CHECK(FlightReader(folder.file("c")).state().signal == 0);
}

TEST_CASE("every signal that ends a process and can be caught is noted, and somebody's own handler stays") {
  const RingFolder folder;
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS, SIGQUIT, SIGALRM,
                           SIGVTALRM, SIGPROF, SIGXCPU, SIGUSR1, SIGUSR2}) {
    INFO(number);
    std::filesystem::remove(folder.file("d"));
    CHECK(death_of(folder.file("d"), [number](FlightRing&) { raise(number); }) == number);
    CHECK(FlightReader(folder.file("d")).state().signal == static_cast<std::uint32_t>(number));
  }
  signal(SIGUSR1, SIG_IGN);
  {
    FlightRing ring(folder.file("e"), plan_of_two());
    const CrashNote note(ring);
    raise(SIGUSR1);
  }
  signal(SIGUSR1, SIG_DFL);
  CHECK(FlightReader(folder.file("e")).state().signal == 0);
}

TEST_CASE("the first ring hears the signals, and afterwards they are whose they were") {
  const RingFolder folder;
  struct sigaction before {};
  sigaction(SIGFPE, nullptr, &before);
  {
    FlightRing first(folder.file("1"), plan_of_two());
    FlightRing second(folder.file("2"), plan_of_two());
    const CrashNote note(first);
    const CrashNote deaf(second);
    first.died(SIGFPE, 1, nullptr);
    first.died(SIGABRT, 1, nullptr);  // what follows a death is not its cause
    struct sigaction now {};
    sigaction(SIGFPE, nullptr, &now);
    CHECK(now.sa_sigaction != before.sa_sigaction);
  }
  struct sigaction after {};
  sigaction(SIGFPE, nullptr, &after);
  CHECK(after.sa_sigaction == before.sa_sigaction);
  CHECK(FlightReader(folder.file("1")).state().signal == SIGFPE);
  CHECK(FlightReader(folder.file("2")).state().signal == 0);
}

}  // namespace sortie::rt::posix
