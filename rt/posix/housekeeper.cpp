// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/housekeeper.hpp"

#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "rt/posix/make_thread.hpp"

namespace sortie::rt::posix {

SetupResult Housekeeper::start(Nanoseconds period_ns) {
  const SetupResult opened = evidence_.open();
  evidence_.sample(monotonic_now());
  thread_ = make_thread("the housekeeper", [this, period_ns] { loop(period_ns); });
  return opened;
}

void Housekeeper::stop() {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void Housekeeper::loop(Nanoseconds period_ns) {
  set_thread_name("housekeeper");
  for (;;) {
    const bool last = stop_.load(std::memory_order_relaxed);
    anchor_fast_clock();
    evidence_.sample(monotonic_now());
    if (last) return;
    sleep_until(monotonic_now() + period_ns);
  }
}

}  // namespace sortie::rt::posix
