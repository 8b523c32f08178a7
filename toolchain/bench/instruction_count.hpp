// SPDX-License-Identifier: BSD-3-Clause
// Counting instructions exactly: callgrind executes the program and writes its count into valgrind's log when
// asked. Costs nothing in a run that does not ask; the header is only needed at build time.
#pragma once

namespace sortie::toolchain {

/// Null, or why this build cannot count, with the cure: no header of valgrind's, or a sanitizer.
const char* why_not_counting();

/// Starts counting; what came before costs hardly more than without.
void start_counting();

/// Writes the count of this thread so far into valgrind's log, as a line "events-THREAD: N". About 0.1 ms.
void mark_count();

}  // namespace sortie::toolchain
