// SPDX-License-Identifier: BSD-3-Clause
// Leads a robot to a goal over ground that it sees as it goes: plans, hands out what is known to carry, plans
// on from there while that is driven, and takes back what turns out not to carry.
#pragma once

#include <cstdint>
#include <span>

#include "planner/ground_path/ground_path.hpp"
#include "planner/ground_way/ground_terrain.hpp"
#include "planner/ground_way/ground_way.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Settings of the planner of ways, beside the lattice's.
struct GroundWayConfig {
  GroundPathConfig lattice;
  GroundRules rules;
  std::uint32_t columns{8192};     ///< GroundPathMemory
  std::uint32_t open{32768};       ///< GroundPathMemory
  std::uint64_t settle{200'000};   ///< units after which the best way so far is taken
  double ahead_m{0.6};             ///< of the way that is driven: where the next plan begins
  double most_pose_age_s{0.5};     ///< an older pose stops the robot
  double most_heights_age_s{1.0};  ///< so long without a scan stops it, too
  double patience_s{6.0};          ///< waits so long for ground to be seen, then gives that ground up

  SORTIE_KEYS(c, key) {
    key("settle_units", c.settle, {1000, 1e9, "", "after so much work the best way so far is taken"});
    key("most_heights_age_s", c.most_heights_age_s,
        {0.05, 60, "s", "without a scan for so long the robot stops"});
    key("ahead_m", c.ahead_m, {0.1, 5, "m", "of the way in force that a new plan leaves as it is"});
    key("patience_s", c.patience_s, {0.5, 600, "s", "waits so long at a border to be seen beyond it"});
  }
};

/// One goal at a time. No heap, no clock. A job: begin(), step() while it works and there are units, end().
/// It costs the cells that are read again, its units, and once a plan a look at each cell. What it hands out
/// leads over cells that carry, by the newest heights; each job looks at all of that again. Memory: that of
/// GroundPath and GroundTerrain.
class GroundWayPlanner {
 public:
  GroundWayPlanner(const GroundWayConfig& config, std::int32_t elevation_cell_mm, rt::Arena& arena);
  bool usable() const { return usable_; }

  /// Work units of a step: about 0.2 ms at the most on a desk.
  static constexpr std::uint32_t kSlice = 500;

  /// `heights_ns`: when the newest scan went into them; `pose`: the newest, in the world of `view`;
  /// `standing`: the robot is at rest. What is driven already is looked at, and a plan begun where one is
  /// due. Status: ok; stale (no pose, or an old one: nothing is handed out); not_finite (of the pose or the
  /// goal).
  Status begin(const mapping::ElevationView& view, const rt::PoseEstimate& pose, bool standing,
               const GroundWayProgress& progress, rt::Nanoseconds heights_ns, rt::Nanoseconds now_ns);
  /// A plan is not done.
  bool works() const { return is_planning_; }
  void step();
  /// The job's output.
  void end();
  const GroundWay& output() const { return output_; }
  const GroundTerrain& terrain() const { return terrain_; }

  void archive(rt::Archive& archive);

 private:
  /// A step as the lattice has it: it begins where the one before ends.
  struct Step {
    std::int64_t x{};  ///< world number of the cell
    std::int64_t y{};
    std::int32_t height_mm{};  ///< above level_m_
    std::int32_t heading{};
    std::uint8_t motion{};  ///< number in the table, of the heading before
    std::uint8_t times{};   ///< so often; 0: the first place
    SORTIE_FIELDS(x, y, height_mm, heading, motion, times)
  };

  void drop_way();
  void verify(const rt::Vector3& p_m);
  bool carries(const Step& from, const Step& step, const rt::Vector3* ahead_of_m) const;
  bool stands(std::int64_t x, std::int64_t y, std::int32_t height_mm, std::int32_t slot) const;
  void cut(std::uint32_t steps);
  void begin_plan(const GroundStance& stance);
  GroundPose find_start(const GroundStance& stance);
  GroundPose find_goal(const GroundStance& stance);
  std::uint32_t driven() const;
  void adopt();
  bool append(const GroundStep& step, const GroundStep& before);
  void refused(GroundPathState state);
  void wait_for_sight();
  GroundPose on_map(const Step& step) const;
  void start_plan();
  bool is_consistent() const;

  GroundWayConfig config_;
  GroundTerrain terrain_;
  GroundPathMemory memory_;
  GroundPath path_;
  bool usable_{};

  std::uint32_t goal_{};
  bool trusts_{};  ///< a goal was told, and where the robot is has to be noted
  GroundWayState state_{};
  Step steps_[GroundWay::kMostSteps];
  std::uint32_t size_{};
  std::uint32_t first_{};  ///< number of steps_[0] in the series
  double level_m_{};       ///< heights of steps count from it
  bool is_planning_{};
  GroundPose plan_start_;
  GroundPose plan_goal_;
  std::uint32_t plan_slices_{};  ///< that it has had
  std::uint32_t plan_from_{};    ///< number of the step where the plan begins
  bool is_intermediate_{};       ///< the plan's goal is a place on the way to it
  std::uint32_t attempt_{};      ///< of intermediate goals that were tried in vain
  std::uint32_t cells_wait_{};   ///< unseen cells of the newest plan
  CellStep unseen_[64];
  std::int64_t unseen_low_[2]{};
  rt::Nanoseconds waits_since_ns_{-1};
  GroundWayProgress progress_;  ///< of this job
  bool standing_{};
  rt::Vector3 p_m_;
  bool adopted_{};  ///< a plan, in this job
  rt::Nanoseconds now_ns_{};
  GroundWay output_;
};

}  // namespace sortie::planner
