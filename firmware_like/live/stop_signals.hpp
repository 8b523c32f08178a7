// SPDX-License-Identifier: BSD-3-Clause
// The signals that ask a command to end in good order. The rule for every command that runs until somebody
// ends it: Ctrl-C (INT), a supervisor (TERM) and a terminal or ssh session that has gone (HUP) mean the same.
// A robot stops, the log is closed, the result is written.
#pragma once

#include <atomic>
#include <csignal>

namespace sortie::firmware {

/// While it lives INT, TERM and HUP set a flag and nothing else; then they are what they were. A HUP that was
/// ignored at the start stays so: that is what `nohup` is for. One at a time; from one thread.
class StopSignals {
 public:
  StopSignals() noexcept;
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Set by the first signal. Lives as long as the program.
  static const std::atomic<bool>& asked() noexcept;
  /// Which one came last, or 0.
  static int number() noexcept;

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction before_[3]{};
};

}  // namespace sortie::firmware
