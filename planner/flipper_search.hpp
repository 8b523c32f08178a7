// SPDX-License-Identifier: BSD-3-Clause
// The search for the four angles that suit the ground ahead, filled in where it is missing.
#pragma once

#include <array>
#include <cstdint>

#include "planner/arc_places.hpp"
#include "planner/flipper_cost.hpp"
#include "planner/missing_ground.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::planner {

/// How angles are searched.
struct FlipperSearchConfig {
  double low_rad{-0.5};  ///< least and most angle of a candidate
  double high_rad{1.3};
  double apart_m{0.04};           ///< left and right are tried apart where the ground differs by more
  double apart_rad{0.3};          ///< by how much
  double rate_rad_s{0.8};         ///< of a flipper
  std::uint32_t units{900};       ///< of work in a job: see kLookUnits; kLeastUnits to 10,000
  std::uint32_t most_tried{120};  ///< candidates, 1 to 200
  double limit{0.01};             ///< most probability of falling below the limits
  FlipperLimits limits{};
  FlipperWeights weights{};
  MissingConfig missing{};
  /// What comes to carry as the vehicle rocks by a degree or two counts as touching.
  PostureConfig posture{.touch_m = 0.015};
};

/// What a search starts from.
struct FlipperQuestion {
  StandPose pose;
  WantedArc arc;  ///< not still
  PostureSolver::Start tilt;
  double measured_rad[rt::kFlippers]{};
  std::uint32_t broken{};  ///< bit f: flipper f stays where it is
  FlipperSet before;       ///< what was asked last: always judged
  FlipperSet feel;         ///< judged at the first two places alone
};

/// A choice that was judged on every ground.
struct JudgedFlippers {
  FlipperSet angles;
  double cost{};              ///< mean over the grounds
  double probability{};       ///< of falling short of a limit (FlipperLimits), of all places
  double near_probability{};  ///< the same of the first two
  double margin_m{};          ///< least on the middle ground
  double clearance_m{};       ///< likewise
  double pitch_rad{};         ///< worst likewise
};

/// What a search found.
struct FlipperFound {
  JudgedFlippers
      best;  ///< cheapest of those that are safe; where none is, the one with the least probability
  JudgedFlippers near;     ///< likewise for the first two places alone
  JudgedFlippers stay;     ///< the measured angles, at the first two places alone
  JudgedFlippers feel;     ///< the question's, likewise
  double stay_height_m{};  ///< of the origin where the vehicle is, by the middle ground
  bool stay_stands{};
  MissingGround::Under under;
  std::uint32_t tried{};
  std::uint32_t units{};
};

/// Front and rear angles on a coarse grid, then on a fine one around the best; then left and right apart.
/// These are judged on the middle ground; a candidate is left as soon as its cost is above that of the best
/// few, which no later place can lower. The best few are judged on all grounds. Each place's ground is read
/// once for all candidates. Fixed order, whole units, no clock: the same answer on every board. About 1.1 MB;
/// no heap.
class FlipperSearch {
 public:
  static constexpr std::uint32_t kLookUnits = 3;  ///< a look takes about as long as so many rests
  static constexpr std::uint32_t kRestUnits = 3;  ///< of a place at most: rocked forward and back, too
  static constexpr std::uint32_t kKept = 3;       ///< judged on all grounds, beside those that stay
  static constexpr int kFine = 13;                ///< angles of the fine grid, each axle
  /// All grounds for the kept and for the measured angles, looks at the middle ground, one candidate.
  static constexpr std::uint32_t kOtherUnits =
      (MissingGround::kPoints - 1) * (kArcPlaces * (kLookUnits + kRestUnits * kKept) + 2 * 2 * kRestUnits);
  static constexpr std::uint32_t kLeastUnits =
      kOtherUnits + kArcPlaces * kLookUnits + (2 * 2 + kArcPlaces) * kRestUnits;

  FlipperSearch(const PostureVehicle& vehicle, const FlipperSearchConfig& config);

  /// That of PostureSolver; out_of_range for a setting of the search.
  Status usable() const { return usable_; }

  /// Status: usable(), or that of MissingGround::take().
  Status search(const HeightView& view, const FlipperQuestion& question, FlipperFound& found);

  /// Angle number k of the fine grid.
  double fine_angle(int k) const {
    return config_.low_rad + (config_.high_rad - config_.low_rad) / (kFine - 1) * k;
  }
  const FlipperSearchConfig& config() const { return config_; }

 private:
  struct Candidate {
    FlipperSet angles;
    FlipperWalk walk;
    double fixed_cost{};
    double rank{};  ///< cost, and much more where it is not safe
  };
  /// A candidate on every ground.
  struct Points {
    double cost[MissingGround::kPoints]{};
    bool failed[MissingGround::kPoints]{};
    bool near_failed[MissingGround::kPoints]{};
    void note(int point, const FlipperWalk& walk, const FlipperWeights& weights);
  };

  Candidate candidate_of(FlipperSet angles) const;
  Posture rest_at(PostureSolver& solver, int place, Candidate& candidate);
  void rock(PostureSolver& solver, const FlipperSet& angles, Posture& posture);
  double try_angles(const FlipperSet& angles);
  void try_grid(int front, int rear);
  void try_grids();
  int higher_side() const;
  void try_apart();
  void judge_near(FlipperFound& found);
  JudgedFlippers sum(const Candidate& candidate, const Points& points) const;
  void judge_kept(FlipperFound& found);

  FlipperSearchConfig config_;
  std::array<PostureSolver, kArcPlaces> middle_;  ///< one a place, on the middle ground
  PostureSolver other_;                           ///< on all the other grounds
  Status usable_{Status::ok};
  MissingGround ground_;
  FlipperQuestion question_;
  StandPose places_[kArcPlaces];
  rt::FixedVector<Candidate, kKept> kept_;  ///< lowest rank first
  rt::FixedVector<Candidate, 2> near_;      ///< the measured angles and those to feel with
  std::array<bool, static_cast<std::size_t>(kFine) * kFine> grid_tried_{};
  double best_rank_{};
  int best_front_{}, best_rear_{};
  std::uint32_t reserve_{}, units_{}, tried_{};
  int points_{1};  ///< grounds that differ
  bool open_{}, near_open_{};
};

}  // namespace sortie::planner
