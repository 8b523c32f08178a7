// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/crash_note.hpp"

#include <signal.h>

#include <atomic>

namespace sortie::rt::posix {
namespace {

// Whatever ends a process, can be caught and is not a wish to end in good order: a fault, then what others
// send. Somebody's own handler of the latter stays.
constexpr int kSignals[] = {SIGSEGV, SIGBUS,  SIGFPE,    SIGILL,  SIGABRT, SIGTRAP, SIGSYS,
                            SIGQUIT, SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGUSR1, SIGUSR2};
constexpr int kFaults = 5;
constexpr int kCount = sizeof(kSignals) / sizeof(kSignals[0]);

std::atomic<FlightRing*> noted_ring{nullptr};
struct sigaction action_before[kCount];

// Only calls that a handler may make: stores, clock_gettime, sigaction, raise.
void note_and_pass_on(int number, siginfo_t* info, void* /*context*/) {
  if (FlightRing* ring = noted_ring.load(std::memory_order_acquire))
    ring->died(number, info->si_code, info->si_addr);
  bool comes_again = false;
  for (int i = 0; i < kCount; ++i) {
    if (kSignals[i] != number) continue;
    sigaction(number, &action_before[i], nullptr);
    comes_again = i < kFaults && info->si_code > 0;
  }
  // A fault comes again by itself as this returns. A signal that was sent would not.
  if (!comes_again) raise(number);
}

}  // namespace

CrashNote::CrashNote(FlightRing& ring) noexcept {
  FlightRing* none = nullptr;
  heard_ = noted_ring.compare_exchange_strong(none, &ring);
  if (!heard_) return;
  struct sigaction action {};
  action.sa_sigaction = note_and_pass_on;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < kCount; ++i) {
    sigaction(kSignals[i], nullptr, &action_before[i]);
    if (i < kFaults || action_before[i].sa_handler == SIG_DFL) sigaction(kSignals[i], &action, nullptr);
  }
}

CrashNote::~CrashNote() {
  if (!heard_) return;
  for (int i = 0; i < kCount; ++i) sigaction(kSignals[i], &action_before[i], nullptr);
  noted_ring.store(nullptr, std::memory_order_release);
}

}  // namespace sortie::rt::posix
