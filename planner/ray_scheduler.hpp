// SPDX-License-Identifier: BSD-3-Clause
// Which rays to fire from the next few positions, so that the map's entropy falls most: an anytime planner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mapping/occupancy_view.hpp"
#include "planner/coverage_table.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_model.hpp"
#include "planner/ray_path.hpp"
#include "planner/ray_plan.hpp"
#include "planner/ray_sensor.hpp"
#include "rt/archive.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Settings of the scheduler.
struct RaySchedulerConfig {
  RaySensor sensor;
  RayModelConfig model;
  std::uint32_t rays{200};                     ///< K, of each position
  std::uint32_t positions{5};                  ///< L at most, 1..16
  double voxel_size_m{0.2};                    ///< of the maps to come, at least
  std::uint64_t map_cells{320u * 320u * 32u};  ///< of the maps to come, at most; 2^24 at most
  std::uint32_t table_lines{};                 ///< of coverage, at most 65535; 0: 52 a ray, 32768 at most
  std::uint32_t path_words{};                  ///< of paths, 16 cells each; 0: 3.5 a direction, 1.5 for L = 1
  std::uint32_t coarse_log2{2};                ///< first, one direction of each 2^n by 2^n is looked at
  std::uint32_t explored{};  ///< directions a position for the joint stage; 0: 7000, 4000 for L = 1
  double optimism{1.0};      ///< what a direction's neighbours may be worth, as its multiple
  double slack{0.02};        ///< a guided stage takes a ray this near to the best bound
  std::uint32_t tries{
      150};  ///< evaluations for one ray of the joint stage, then the best; a sixth for a position
  bool position_first{true};  ///< stages
  bool joint{true};
  bool exact{true};
  bool certify{true};
};

/// Plans min(K, N) different rays for each of L positions. At every moment it holds a complete, valid plan:
/// first the previous one moved on (or a fixed pattern), then position after position (its rays are fired
/// next), then all together by guided refinement and lazy greedy choice, then the lazy greedy choice among
/// all directions. A plan is replaced only by one that is surely worth more, so more units never give less.
/// What it does depends on the input and on the units spent, never on a clock, nor on how units were sliced.
///
/// Memory is the caller's; no heap. Cost: about 2 to 5 ns a unit.
class RayScheduler {
 public:
  static constexpr std::uint32_t kMostPositions = 16;
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

  const RayModel& model() const { return model_; }
  const RaySchedulerConfig& config() const { return config_; }
  /// Between two tasks: the plan to bytes and back, into a scheduler of the same configuration. A task that
  /// was under way is over then.
  void archive(rt::Archive& archive);
  /// The walk of a ray of the present task; for tests and pictures. The pose lies in the window.
  mapping::VoxelWalk walk(std::uint32_t position, std::uint32_t ray) const;

 private:
  enum class Phase : std::uint8_t {
    seed_bound,     // trace the seed's rays
    coarse,         // trace the coarse directions of a position
    build,          // fill the heap for a selection
    select,         // choose
    complete,       // positions with too few rays get more
    decide,         // is the candidate surely better?
    weigh,          // the exact worth of the candidate or of the best plan
    clear,          // empty the table; then what waits for that
    reload,         // the table again as before weighing
    next_stage,     // what comes next
    explore,        // trace directions where the best ones are
    trace_all,      // every direction
    certify_build,  // fill the heap for the bound
    certify,        // the best marginal worths of each position
    done,
  };
  // What is known of a plan's worth.
  struct Bounds {
    double lower{};
    double upper{};
    bool weighed{};
  };
  // A position's pose in the window.
  struct View {
    rt::Vector3 u;
    rt::Vector3 up;
    std::uint32_t cell{};  // where it is
    bool inside{};
  };

  void lay_out(std::span<std::byte> memory);
  void make_views(std::span<const mapping::SensorPose> poses);
  void make_seed(std::uint32_t passed, std::uint32_t previous_positions);
  void start_selection(RayStage stage, std::uint32_t first, std::uint32_t last);
  std::uint32_t advance();
  std::uint32_t trace_coarse();
  std::uint32_t trace_seed();
  std::uint32_t trace_next();
  std::uint32_t build_next();
  std::uint32_t select_next();
  std::uint32_t complete_next();
  std::uint32_t decide();
  void clear_table_then(Phase phase);
  std::uint32_t clear_next();
  std::uint32_t weigh_next();
  std::uint32_t reload_next();
  std::uint32_t next_stage();
  std::uint32_t certify_build_next();
  std::uint32_t certify_next();
  void start_weighing(bool candidate);
  void finish_certificate();
  void adopt();

  std::uint32_t trace(std::uint32_t position, std::uint32_t ray, bool beside, float& worth);
  std::uint32_t evaluate(std::uint32_t node, float& worth);
  std::uint32_t cover(std::uint32_t position, std::uint32_t ray, RayWorth& worth, bool& entered);
  std::uint32_t take(std::uint32_t node);
  std::uint32_t explore_next();
  std::uint32_t refine(std::uint32_t node);
  std::uint32_t push_cell(std::uint32_t position, std::uint32_t x, std::uint32_t y, std::uint32_t level);
  std::uint32_t push_ray(std::uint32_t position, std::uint32_t ray, std::uint32_t level, float worth);
  std::uint32_t pattern(std::uint32_t i) const;

  static bool bit(std::span<const std::uint32_t> bits, std::uint32_t i) {
    return (bits[i >> 5] >> (i & 31u) & 1u) != 0;
  }
  static void set_bit(std::span<std::uint32_t> bits, std::uint32_t i) { bits[i >> 5] |= 1u << (i & 31u); }
  static void put_bit(std::span<std::uint32_t> bits, std::uint32_t i, bool value) {
    bits[i >> 5] &= ~(1u << (i & 31u));
    if (value) set_bit(bits, i);
  }

  RaySchedulerConfig config_;
  RayModel model_;
  std::uint32_t all_rays_{};
  std::uint32_t per_position_{};
  std::uint32_t most_cells_{};
  std::uint32_t coarse_columns_{};
  std::uint32_t coarse_rows_{};
  std::uint64_t largest_step_{};
  bool usable_{};

  std::span<RayAngle> columns_;
  std::span<RayAngle> rows_;
  std::span<rt::Vector3> across_;    // by position and column: the horizontal part of directions, turned
  std::span<float> fresh_;           // worth of each traced direction beside no other
  std::span<std::uint32_t> traced_;  // bits
  std::span<std::uint32_t> chosen_;  // bits of the selection under way
  std::span<std::uint32_t> path_;    // number of the path of each traced direction; 0: it was not kept
  std::span<std::uint16_t> best_rays_;
  std::span<std::uint16_t> work_rays_;
  std::span<RayModel::Passed> scratch_;
  RayHeap heap_;
  CoverageTable table_;
  RayPaths paths_;

  mapping::OccupancyView map_;
  View views_[kMostPositions];
  RayPlan plan_;
  Phase phase_{Phase::done};
  Phase after_clear_{Phase::done};
  std::uint64_t credit_{};
  Bounds best_;
  Bounds work_;
  double seed_bound_[kMostPositions]{};
  std::uint32_t counts_[kMostPositions]{};
  RayStage stage_{};       // of the selection under way
  std::uint32_t first_{};  // positions of the selection
  std::uint32_t last_{};
  std::uint32_t left_{};  // rays that the selection still wants
  std::uint32_t cursor_{};
  std::uint32_t coarse_{};    // positions whose coarse directions were traced
  std::uint32_t tries_{};     // evaluations for the next ray
  std::uint64_t tried_{};     // best key of them
  bool candidate_weighed_{};  // which plan weigh is about
  bool disturbed_{};          // weighing used the table
  bool all_traced_{};
  double chosen_worth_{};  // of the rays in the table
  double marginal_sum_{};
  double rest_upper_{};  // of the plan that is weighed, without the first position
};

}  // namespace sortie::planner
