// SPDX-License-Identifier: BSD-3-Clause
// What a flight ring holds, for other tools and for a person.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>

#include "rt/posix/flight_reader.hpp"
#include "toolchain/export/chrome_trace.hpp"

namespace sortie::toolchain {

/// Jobs as spans of their groups' tracks with their tasks inside, the threads' own spans within, events as
/// marks.
Trace to_trace(const rt::posix::FlightReader& ring);

/// In words: what ran, how it ended, which task it died in, the last `count` jobs of each group and the last
/// events.
void print_last_jobs(std::ostream& out, const rt::posix::FlightReader& ring, std::size_t count);

}  // namespace sortie::toolchain
