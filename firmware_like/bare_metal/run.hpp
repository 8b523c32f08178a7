// SPDX-License-Identifier: BSD-3-Clause
// Replays a recording through an executive on a polled clock, and prints what a test wants to know.
#pragma once

#include <cstddef>

#include "firmware_like/bare_metal/board.hpp"
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

/// The whole of main(): replays through a Robot, which is made of an executive and has take(record).
template <class Robot>
[[noreturn]] void run() {
  paint_stack();
  // On a board the odometry leaves 0.1 kB of 8 KiB. With the large tables of a desktop it takes 41 kB.
  alignas(16) static std::byte memory[rt::kMaxGroups > 2 ? 64 * 1024 : 8 * 1024];
  static rt::Arena arena(memory);
  static rt::Executive executive(arena, rt::kNanosecondsPerMillisecond, 0);
  static Robot robot(executive);
  replay(executive,
         {&robot, [](void* self, const Record& record) { static_cast<Robot*>(self)->take(record); }});
}

}  // namespace sortie::bare
