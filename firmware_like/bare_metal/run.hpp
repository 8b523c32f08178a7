// SPDX-License-Identifier: BSD-3-Clause
// Replays a recording through an executive on a polled clock, and prints what a test wants to know.
#pragma once

#include <cstdint>

#include "firmware_like/bare_metal/recording.hpp"
#include "rt/executive.hpp"

namespace sortie::bare {

/// Takes the records of a tick into the robot's streams.
struct RecordSink {
  void* self{};
  void (*take)(void* self, const Record& record){};
};

/// Runs until the recording ends, then prints JSON on one line: ticks, records, jobs, digest, memory of the
/// arena, counts of the dearest and of all jobs, in steps of the board's counter. Does not come back. Exit
/// codes: 0; 3: no recording, or one that is cut off; 1: the table could not be built.
[[noreturn]] void replay(rt::Executive& executive, RecordSink sink);

}  // namespace sortie::bare
