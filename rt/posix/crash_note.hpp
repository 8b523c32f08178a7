// SPDX-License-Identifier: BSD-3-Clause
// Puts the signal that a process dies of into its flight ring.
#pragma once

#include "rt/posix/flight_ring.hpp"

namespace sortie::rt::posix {

/// While it lives, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT of this process are noted in a ring, and
/// whatever else would end it and has no handler: SIGQUIT, SIGXCPU, SIGUSR1 and the like. Then what was to be
/// done about the signal before is done, so that cores are dumped and exit codes are as ever. INT, TERM and
/// HUP are no deaths but wishes to end (firmware_like/live/stop_signals.hpp). One at a time: of several the
/// first is heard, the others do nothing. Costs nothing until a signal comes. Not noted: SIGKILL, which
/// nobody can catch, and the overflow of a thread's stack, which leaves the handler no stack to run on; the
/// ring tells the last tick and the running task of those, too.
class CrashNote {
 public:
  /// `ring` outlives it.
  explicit CrashNote(FlightRing& ring) noexcept;
  ~CrashNote();
  CrashNote(const CrashNote&) = delete;
  CrashNote& operator=(const CrashNote&) = delete;

 private:
  bool heard_{};
};

}  // namespace sortie::rt::posix
