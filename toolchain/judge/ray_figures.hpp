// SPDX-License-Identifier: BSD-3-Clause
// What the plans of a run were like: how far they got with their units, what they are worth at least, and
// which came late.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"

namespace sortie::toolchain {

/// One line of a table of figures.
struct FigureRow {
  std::string name;
  std::string value;
  std::string unit;
};

/// Follows the jobs of task `ssl`, if the scene has one. Memory: 32 bytes a job.
class RayFigures {
 public:
  /// After each job of any group, on the thread that ran it, one at a time (ReplayOptions::on_job).
  void job(const rt::JobRecord& record, const firmware::Runtime& runtime);

  /// Commands, late and cut plans, units, stages, certificates, from `first` on; empty without jobs. A
  /// certificate is at least the share of the best possible worth that the plan has
  /// (planner/ray_scheduler.hpp).
  std::vector<FigureRow> rows(rt::Tick first) const;

 private:
  struct Plan {
    rt::Tick tick{};
    std::uint32_t units{};
    std::uint8_t stage{};
    bool late{};       ///< missed the deadline: not sent
    bool cut{};        ///< by the wall-clock guard
    bool shed{};       ///< the ladder left the job out
    bool unplanned{};  ///< strides were asked for
    double certificate{};
  };
  void find(const firmware::Runtime& runtime);

  const firmware::Runtime* runtime_{};
  const rt::TaskBase* task_{};
  std::uint32_t place_{};  ///< of the task in its group
  std::uint64_t unplanned_{};
  std::vector<Plan> plans_;
};

}  // namespace sortie::toolchain
