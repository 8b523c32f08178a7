// SPDX-License-Identifier: BSD-3-Clause
// What the recorder knows of the tasks' run times.
#include "firmware_like/log/log_recorder.hpp"

namespace sortie::firmware {

std::vector<drivers::TaskTiming> LogRecorder::timings() const {
  std::vector<drivers::TaskTiming> result;
  const rt::Executive& executive = runtime_.executive();
  const std::lock_guard lock(statistics_);
  for (std::uint32_t group = 0; group < executive.group_count(); ++group) {
    for (std::uint32_t i = 0; i < executive.group(group).tasks.size(); ++i) {
      const rt::TaskBase& task = *executive.group(group).tasks[i];
      const rt::LatencyHistogram& wall = histograms_[group][i];
      result.push_back({task.name(), static_cast<std::int64_t>(wall.count()),
                        static_cast<std::int64_t>(missed_[group]),
                        static_cast<double>(wall.percentile(0.5)) * 1e-3,
                        static_cast<double>(wall.percentile(0.99)) * 1e-3,
                        static_cast<double>(wall.max()) * 1e-3, static_cast<double>(task.budget_us())});
    }
  }
  return result;
}

}  // namespace sortie::firmware
