// SPDX-License-Identifier: BSD-3-Clause
// How a run ended, as its flight ring tells it.
#pragma once

#include <string>

#include "rt/posix/flight_reader.hpp"

namespace sortie::firmware {

/// How the run ended, in one line: by itself, still running, or died of what, at which tick, in which task.
std::string ending_of(const rt::posix::FlightReader& ring);

}  // namespace sortie::firmware
