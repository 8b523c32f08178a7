// SPDX-License-Identifier: BSD-3-Clause
// The rays that were entered in the table of coverage: which they are, what they leave, what they are worth.
#pragma once

#include <cstdint>
#include <span>

#include "planner/coverage_table.hpp"
#include "planner/ray_config.hpp"
#include "planner/ray_model.hpp"

namespace sortie::planner {

/// A set of rays S in one piece. Whether a ray is in S, what S has left of each cell, and what S is worth
/// change together or not at all: so what is proved from worth() and holds() is true of the table, whoever
/// filled it, in whatever order, and whatever it refused. Rays are numbered position * N + ray.
class RayCover {
 public:
  RayCover() = default;
  /// `bits`: one a ray. `scratch`: as many cells as a ray has at most.
  RayCover(const CoverageMemory& memory, std::span<std::uint32_t> bits, std::span<RayModel::Passed> scratch)
      : table_(memory), held_(bits), scratch_(scratch) {}

  /// Empties `lines` lines of the table; true when S is empty. Until then nothing may be asked or entered.
  bool clear_some(std::uint32_t lines) {
    if (!table_.clear_some(lines)) return false;
    held_.clear();
    worth_ = 0.0;
    return true;
  }
  /// Enters a ray that is not held. False, and nothing is changed, where the table might not take it;
  /// `worth` is what it adds, or would add.
  template <class Walk>
  bool enter(std::uint32_t ray, const RayModel& model, Walk walk, const std::int8_t* cells, RayWorth& worth) {
    if (!model.cover(walk, cells, table_, scratch_, worth)) return false;
    held_.set(ray);
    worth_ += worth.current;
    return true;
  }

  bool holds(std::uint32_t ray) const { return held_.has(ray); }
  /// Of all rays held, nats.
  double worth() const { return worth_; }
  const CoverageTable& table() const { return table_; }

 private:
  CoverageTable table_;
  RayBits held_;
  std::span<RayModel::Passed> scratch_;
  double worth_{};
};

/// What the table was in a task, for reports.
struct RayTableUse {
  std::uint32_t most_lines{};
  bool refused{};  ///< a ray that was chosen or weighed
};

}  // namespace sortie::planner
