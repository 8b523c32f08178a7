// SPDX-License-Identifier: BSD-3-Clause
// Which rays to fire from the next few positions, so that the map's entropy falls most: an anytime planner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "mapping/occupancy/occupancy_view.hpp"
#include "planner/ray_certificate.hpp"
#include "planner/ray_config.hpp"
#include "planner/ray_cover.hpp"
#include "planner/ray_exploration.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_looks.hpp"
#include "planner/ray_plan.hpp"
#include "planner/ray_selection.hpp"
#include "planner/ray_weighing.hpp"
#include "rt/archive.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Plans min(K, N) different rays for each of L positions. At every moment it holds a complete, valid plan:
/// first the previous one moved on (or a fixed pattern), then position after position (its rays are fired
/// next), then all together by guided refinement and lazy greedy choice, then the lazy greedy choice among
/// all directions. A plan is replaced only by one that is surely worth more, so more units never give less.
/// What it does depends on the input and on the units spent, never on a clock, nor on how units were sliced.
///
/// Its parts: RayLooks knows the directions, RayCover the rays that were entered, RayExploration looks where
/// the best ones are, RaySelection chooses, RayWeighing says what a plan is worth and RayCertificate what
/// none can be worth more than. This class has the order of the stages, the budget and the best plan.
///
/// Memory is the caller's; no heap. Cost: about 2 to 5 ns a unit.
class RayScheduler {
 public:
  static constexpr std::uint32_t kMostPositions = RaySizes::kMostPositions;
  static constexpr std::uint32_t kNothingPassed = 0xffffffff;

  /// Bytes that a config asks for; 0 when it is not usable.
  static std::uint64_t memory_bytes(const RaySchedulerConfig& config);
  /// `memory`: memory_bytes(config) or more. usable() is false when there is less, or a setting is out of its
  /// range.
  RayScheduler(const RaySchedulerConfig& config, std::span<std::byte> memory);
  RayScheduler(const RayScheduler&) = delete;
  RayScheduler& operator=(const RayScheduler&) = delete;
  bool usable() const { return usable_; }

  /// A new task: the rays of these sensor poses, the next one first, over this map, which must not change
  /// until the plan is taken. `passed`: how many positions of the previous task were left behind, so that its
  /// plan is moved on by that many; kNothingPassed: start from the pattern. A valid plan is there at once. A
  /// pose outside the window has a plan whose rays are worth nothing. Status: out_of_range (map too large,
  /// too fine, or more than L poses); not_finite; the task before goes on then. Cost:
  /// some 10 us, and a few ns for each line of coverage that the task before had used.
  Status begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses,
               std::uint32_t passed = kNothingPassed);
  /// Spends at most `units` and what earlier slices left over (less than largest_step()). Returns what was
  /// spent by this call.
  std::uint64_t step(std::uint64_t units);
  /// True when more units change nothing.
  bool done() const { return phase_ == Phase::done; }
  /// Units of the dearest single step: what a budget may leave unused.
  std::uint64_t largest_step() const { return largest_step_; }

  /// The best plan so far, and its rays at a position: numbers as in RaySensor, in the order of choice.
  const RayPlan& plan() const { return plan_; }
  std::span<const std::uint16_t> rays(std::uint32_t position) const;

  const RayModel& model() const { return looks_.model(); }
  const RaySchedulerConfig& config() const { return config_; }
  /// Between two tasks: the plan to bytes and back, into a scheduler of the same configuration. A task that
  /// was under way is over then.
  void archive(rt::Archive& archive);
  /// The walk of a ray of the present task; for tests and pictures. The pose lies in the window.
  mapping::VoxelWalk walk(std::uint32_t position, std::uint32_t ray) const {
    return looks_.walk(position, ray);
  }

 private:
  enum class Phase : std::uint8_t {
    seed_bound,  // trace the seed's rays
    coarse,      // trace the coarse directions of a position
    select,      // choose
    decide,      // is the candidate surely better?
    weigh,       // the exact worth of the candidate or of the best plan
    clear,       // empty the cover; then what waits for that
    reload,      // the cover again as before weighing
    next_stage,  // what comes next
    explore,     // trace directions where the best ones are
    trace_all,   // every direction
    certify,     // what no plan is worth more than
    done,
  };

  static constexpr double kUnknownBound = std::numeric_limits<double>::infinity();

  void lay_out(std::span<std::byte> memory);
  void make_seed(std::uint32_t passed, std::uint32_t previous_positions);
  std::uint32_t pattern(std::uint32_t i) const;
  std::uint32_t advance();
  std::uint32_t trace_coarse();
  std::uint32_t trace_seed();
  std::uint32_t trace_next();
  std::uint32_t explore_next();
  std::uint32_t select_next();
  std::uint32_t decide();
  std::uint32_t weigh_next();
  std::uint32_t clear_next();
  std::uint32_t reload_next();
  std::uint32_t certify_next();
  std::uint32_t next_stage();
  void start_selection(RayStage stage, std::uint32_t first, std::uint32_t last);
  void start_weighing(bool candidate);
  void clear_cover_then(Phase phase);
  void adopt();
  void set_bound(double bound);
  void finish_certificate();
  void note_parts();

  RaySchedulerConfig config_;
  RaySizes sizes_;
  bool usable_{};
  std::uint64_t largest_step_{};

  // What the parts work on.
  RayHeap heap_;
  RayCover cover_;
  RayTableUse use_;
  RayLooks looks_;
  RayExploration exploration_;
  RaySelection selection_;
  RayWeighing weighing_;
  RayCertificate certificate_;

  std::span<std::uint16_t> best_rays_;
  RayPlan plan_;
  Phase phase_{Phase::done};
  Phase after_clear_{Phase::done};
  std::uint64_t credit_{};
  RayBounds best_;  // of the plan
  RayBounds work_;  // of the candidate
  double seed_bound_[kMostPositions]{};
  RayStage stage_{};          // that is under way
  std::uint32_t last_{};      // positions that it has planned
  std::uint32_t cursor_{};    // of the phases that trace, and of reload
  std::uint32_t coarse_{};    // positions whose coarse directions were traced
  bool candidate_weighed_{};  // which plan is weighed
  bool disturbed_{};          // weighing used the cover
  bool all_traced_{};
};

}  // namespace sortie::planner
