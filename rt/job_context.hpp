// SPDX-License-Identifier: BSD-3-Clause
// What a task's function knows of the job that it runs in, and its budget of work units.
#pragma once

#include <cstdint>

#include "rt/fields.hpp"
#include "rt/job_record.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

template <Described T>
class Task;

/// Most work units that any task may be given.
inline constexpr std::uint32_t kUnlimitedUnits = ~0u;

/// What a task function may ask about the job it runs in. All of it is part of the recorded inputs.
class JobContext {
 public:
  /// The run's clock; read for statistics, deadlines and the wall-clock guard only.
  using Clock = Nanoseconds (*)(void*);

  Tick tick{};               ///< release of this job
  std::uint64_t job{};       ///< number of this release within the group
  Nanoseconds release_ns{};  ///< release on the run's clock: epoch + tick * base tick
  Nanoseconds period_ns{};   ///< of the group
  Nanoseconds due_ns{};      ///< deadline of this job: its outputs are visible from then on

  /// Counts work units without asking for leave: what a task cannot do without. Recorded with the job. Behind
  /// a cut by the wall-clock guard nothing counts any more: the number at the cut is where a replay stops.
  void add_units(std::uint32_t units) {
    if (!is_cut()) record_->units[task_] += units;
  }

  /// Asks for `units` more of the work-unit budget, before they are spent. An anytime task makes its base
  /// result first, then refines as long as this says true; after a false it must stop, and keeps what it has.
  /// So it stops at exactly the same unit in a replay, also where a live run's wall-clock guard has cut it.
  [[nodiscard]] bool spend(std::uint32_t units = 1) {
    std::uint32_t& spent = record_->units[task_];
    // Where the table has room left, this is where the recorded job was cut.
    if (spent > limit_ || limit_ - spent < units) return refuse(limit_ < granted_ && units_left() >= units);
    if (guard_ns_ != 0 && clock_(clock_self_) >= guard_ns_) {
      limit_ = spent;
      return refuse(true);
    }
    spent += units;
    return true;
  }
  /// Units that are left of the declared budget (kUnlimitedUnits without one). A cut by the wall-clock guard
  /// cannot be foreseen, and is not.
  std::uint32_t units_left() const {
    const std::uint32_t spent = record_->units[task_];
    if (granted_ == kUnlimitedUnits) return granted_;
    return spent >= granted_ ? 0 : granted_ - spent;
  }

 private:
  friend class Executive;
  friend class TaskBase;
  template <Described T>
  friend class Task;

  bool is_cut() const { return (record_->cut >> task_ & 1u) != 0; }
  bool refuse(bool cut) {
    if (cut) record_->cut = static_cast<std::uint16_t>(record_->cut | (1u << task_));
    return false;
  }
  JobRecord* record_{};
  std::uint32_t task_{};
  std::uint32_t granted_{kUnlimitedUnits};  // by the table and the ladder
  std::uint32_t limit_{kUnlimitedUnits};    // as granted, or where the recorded job was cut
  Nanoseconds guard_ns_{};
  Clock clock_{};
  void* clock_self_{};
  bool record_fields_{};
  bool digests_{true};
};

}  // namespace sortie::rt
