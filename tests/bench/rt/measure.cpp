// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/rt/measure.hpp"

#include <iostream>

#include "rt/posix/realtime.hpp"

namespace sortie::bench {

void say(const std::string& words) { std::cerr << "bench rt: " << words << std::endl; }

RealtimeSlice::RealtimeSlice(const Settings& settings, int core, int priority) {
  // A refusal was found and named at the start.
  if (core >= 0) static_cast<void>(rt::posix::pin_to_core(core).ok);
  if (settings.realtime) static_cast<void>(rt::posix::set_fifo_priority(priority).ok);
}

RealtimeSlice::~RealtimeSlice() { static_cast<void>(rt::posix::set_ordinary_priority().ok); }

}  // namespace sortie::bench
