// SPDX-License-Identifier: BSD-3-Clause
// Measures all chains of a runtime during a run.
#pragma once

#include <memory>
#include <vector>

#include "firmware_like/chain_meter.hpp"
#include "firmware_like/runtime.hpp"

namespace sortie::firmware {

/// One meter a chain. Fed with every job's record, off the real-time path, by one thread at a time.
class ChainWatch {
 public:
  /// `on_run_clock`: a live run in real time. Lives no longer than `runtime`.
  ChainWatch(const Runtime& runtime, bool on_run_clock);

  void job(const rt::JobRecord& record) {
    for (const auto& meter : meters_) meter->job(record);
  }
  /// Puts what was measured beside what was computed, in the results of that runtime. A reaction more than a
  /// tick beyond its bound becomes a warning if no release was missed, skipped or shed; so do samples that
  /// came too far apart.
  void add_to(Results& results) const;

 private:
  std::vector<std::unique_ptr<ChainMeter>> meters_;  // in the order of the runtime's chains
};

}  // namespace sortie::firmware
