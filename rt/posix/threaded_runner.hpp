// SPDX-License-Identifier: BSD-3-Clause
// A virtual clock with one worker thread a group. Same outputs as on one thread; this is where timing is
// perturbed in tests, because a single thread cannot show a fault of hand-over between groups.
#pragma once

#include "rt/virtual_runner.hpp"

namespace sortie::rt::posix {

/// Runs ticks first..last (inclusive). Jobs of different groups overlap as far as their deadlines allow: a
/// tick opens when every job that is due by then is decided. Not for live use: it waits on locks. Throws
/// ThreadRefused when a thread cannot be made.
void run_virtual_threaded(Executive& executive, JobFeed& feed, Tick first, Tick last);

}  // namespace sortie::rt::posix
