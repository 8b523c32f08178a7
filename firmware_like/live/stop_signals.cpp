// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/stop_signals.hpp"

namespace sortie::firmware {
namespace {

std::atomic<bool> stop_asked{false};
std::atomic<int> stop_number{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void note(int number) {
  stop_number.store(number, std::memory_order_relaxed);
  stop_asked.store(true, std::memory_order_relaxed);
}

}  // namespace

StopSignals::StopSignals() noexcept {
  stop_number.store(0, std::memory_order_relaxed);
  stop_asked.store(false, std::memory_order_relaxed);
  struct sigaction action {};
  action.sa_handler = note;
  action.sa_flags = SA_RESTART;  // poll() and sleeps end all the same
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < 3; ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (kSignals[i] == SIGHUP && before_[i].sa_handler == SIG_IGN) continue;
    sigaction(kSignals[i], &action, nullptr);
  }
}

StopSignals::~StopSignals() {
  for (int i = 0; i < 3; ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

const std::atomic<bool>& StopSignals::asked() noexcept { return stop_asked; }

int StopSignals::number() noexcept { return stop_number.load(std::memory_order_relaxed); }

}  // namespace sortie::firmware
