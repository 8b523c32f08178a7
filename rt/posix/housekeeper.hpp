// SPDX-License-Identifier: BSD-3-Clause
// The ordinary thread of a live run that does small chores nobody waits for: keeps the fast clock right and
// reads the counters of the cores.
#pragma once

#include <atomic>
#include <thread>

#include "rt/posix/delay_evidence.hpp"

namespace sortie::rt::posix {

/// Owns the thread and what it collects. About 0.2 % of a core at 10 ms.
class Housekeeper {
 public:
  Housekeeper() = default;
  ~Housekeeper() { stop(); }
  Housekeeper(const Housekeeper&) = delete;
  Housekeeper& operator=(const Housekeeper&) = delete;

  /// Set-up: opens the counters, so that evidence() is complete from here on, and starts the thread. The
  /// result says which evidence is missing; the thread runs all the same. Throws ThreadRefused. Start it
  /// from a thread with ordinary priority: the new thread inherits that.
  SetupResult start(Nanoseconds period_ns = 10 * kNanosecondsPerMillisecond);
  /// Ends the thread, after one last look, so that no case is left without witnesses. May be called twice.
  void stop();
  const CoreEvidence& evidence() const { return evidence_; }

 private:
  void loop(Nanoseconds period_ns);

  CoreEvidence evidence_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sortie::rt::posix
