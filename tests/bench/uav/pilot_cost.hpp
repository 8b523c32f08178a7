// SPDX-License-Identifier: BSD-3-Clause
// Run time of what was flown: the same inputs again, without the plant.
#pragma once

#include <ctime>

#include "tests/bench/uav/flight.hpp"

namespace sortie::bench {

/// CPU time of the calling thread, us.
inline double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Least of five runs over all states of a tracked flight: run time of the pilot, us per second of flight.
double pilot_cost_us_s(const FlightSetup& setup, const FlightResult& flown);

}  // namespace sortie::bench
