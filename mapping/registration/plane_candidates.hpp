// SPDX-License-Identifier: BSD-3-Clause
// Under one rotation: which planes may match, and the shifts that many of them agree on.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/plane_registration_config.hpp"
#include "mapping/registration/plane_side.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// A shift along one direction, and what the pairs that agree on it gain; each plane counts once.
struct ShiftPeak {
  double at_m{};
  double gain{};
  std::uint32_t first{};  ///< of these pairs, in the order of their axis
  std::uint32_t end{};
  std::uint32_t planes{};  ///< of the smaller side among them
};

/// What a look at a shift found.
struct ShiftLook {
  double gain{};
  double of_axis[3]{};      ///< the part that pairs of each axis have in it
  std::uint32_t matched{};  ///< planes of the smaller side
  bool whole{};             ///< false: it stopped early, and `gain` is the most that it could have been
};

/// Most peaks of an axis.
inline constexpr std::uint32_t kMostShiftPeaks = 10;

/// A direction in which pairs of parallel planes vote for shifts.
struct ShiftAxis {
  rt::Vector3 axis;
  std::uint8_t family{};
  std::uint32_t first{};  ///< of its pairs, sorted by their shift
  std::uint32_t pairs{};  ///< that voted: inside the bounds that an estimate gives
  rt::FixedVector<ShiftPeak, kMostShiftPeaks> peaks;  ///< most gain first
};

/// Pairs of planes under one rotation and scale, in the order of their sides: largest source planes first.
/// All places are relative to the middles of the two sides: x_target - middle = scale R (x_source - middle) +
/// t. 2.0 MB.
class PlaneCandidates {
 public:
  PlaneCandidates();

  /// One look at every pair: normals within most_angle_rad, areas within most_area_ratio. What a match of a
  /// pair is worth: ln of (length of the target along the normal / width of a match / targets that this
  /// source plane might have matched by chance), plus ln share_matched.
  void pair_up(const PlaneSide& source, const PlaneSide& target, const rt::Quaternion& q_target_source,
               const PlaneRegistrationConfig& config);

  /// Scales that ratios of distances between parallel planes vote for, within 3 sigma of the estimate's; at
  /// most 6, best first. At most 192 pairs a direction are looked at two by two.
  void find_scales(const PlaneEstimate& estimate, rt::FixedVector<double, 8>& scales) const;

  /// Shifts for one scale: pairs of the three families of target planes that have most of them, and are
  /// not near one plane, agree where they lie within 0.3 m. Fewer than three axes where there are no others.
  /// Cost: sorting the pairs.
  void find_shifts(double scale, const PlaneEstimate& estimate);

  /// Most that the pairs of peak `i` of axis `a` can gain where the shift along axis `b` is that of its peak
  /// `j`: those whose rectangles meet along b. Worked out once.
  double gain_given(std::uint32_t a, std::uint32_t i, std::uint32_t b, std::uint32_t j);

  /// Gain of the pairs of one peak of each axis whose rectangles overlap at the shift, and of all other pairs
  /// within the loose gate; each plane counts once. Stops where it cannot be more than `least`.
  ShiftLook look_at(const rt::Vector3& t_m, const std::uint32_t (&peak)[3], double least);

  /// Planes of the smaller side that lie within the other side's box at a shift; counts no
  /// further than `enough`.
  std::uint32_t covered_at(const rt::Vector3& t_m, std::uint32_t enough) const;

  std::uint32_t size() const { return size_; }
  PlanePair pair(std::uint32_t k) const { return {source_of_[k], target_of_[k], opposite_[k]}; }
  /// Worth of a pair without its residual and without the width of its own match.
  double worth(std::uint32_t k) const { return worth_[k]; }
  std::uint32_t axes() const { return axes_; }
  const ShiftAxis& axis(std::uint32_t k) const { return axis_[k]; }
  /// The shift whose parts along the axes are given; along other directions that of the estimate.
  rt::Vector3 shift(const double (&along)[3]) const;
  /// Most gain that planes outside the three families can add.
  double rest_gain() const { return rest_gain_; }
  /// How many planes of the smaller side these can be.
  std::uint32_t rest_planes() const { return rest_planes_; }
  std::uint32_t dropped() const { return dropped_; }
  /// The pose of a shift.
  PlanePose pose(const rt::Vector3& t_m) const;

 private:
  struct Rotated {
    rt::Vector3 centroid;  ///< turned, not scaled, from the middle
    rt::Vector3 middle;    ///< of the rectangle, likewise
    rt::Vector3 a;
    rt::Vector3 b;
  };
  /// What overlap() of a pair's rectangles comes to when only the shift changes. 40 bytes.
  struct Overlap {
    float u{};            ///< middle of the source's rectangle from the middle of the target's at no shift,
    float v{};            ///< along the target's axes
    float across_a[2]{};  ///< square to the sides of the source's, unit
    float across_b[2]{};
    float reach[4]{};  ///< along u, v and these two: half of both shadows, and the margin
  };
  static constexpr float kUnknown = -1.0f;  ///< a reach not yet worked out

  /// Best gain of each plane, while gains are summed.
  class Tally {
   public:
    void add(std::uint16_t source, std::uint16_t target, double gain);
    /// Sum over sources or over targets, the smaller one, and how many planes of one side; empties the tally.
    double take(bool of_source, std::uint32_t& planes);

   private:
    double by_source_[kMostPlanes]{};
    double by_target_[kMostPlanes]{};
    std::uint16_t sources_[kMostPlanes]{};
    std::uint16_t targets_[kMostPlanes]{};
    std::uint32_t source_count_{};
    std::uint32_t target_count_{};
  };
  /// A pair, the shift that it votes for, and along each axis how far its rectangles are apart at no shift
  /// and how far they may be.
  struct Vote {
    double at_m;
    std::uint32_t pair;
    float apart_m[3];
    float reach_m[3];
  };

  void choose_axes();
  void vote(ShiftAxis& axis, const PlaneEstimate& estimate);
  void find_peaks(ShiftAxis& axis);
  void find_shadows(const ShiftAxis& axis);
  bool overlaps(std::uint32_t pair, const rt::Vector3& t_m);
  void prepare(std::uint32_t pair);
  void invert_axes(const PlaneEstimate& estimate);

  const PlaneSide* source_{};
  const PlaneSide* target_{};
  rt::Quaternion q_;
  double scale_{1};
  double gate_m_{};
  double margin_m_{};
  std::uint32_t size_{};
  std::uint32_t dropped_{};
  std::uint32_t axes_{};
  double rest_gain_{};
  std::uint32_t rest_planes_{};
  ShiftAxis axis_[3];
  rt::Vector3 dual_[3];  ///< shift = sum of parts along axes times these + rest
  rt::Vector3 rest_;
  Rotated rotated_[kMostPlanes];
  rt::Vector3 centred_[kMostPlanes];      ///< target's centroids
  rt::Vector3 across_[kMostPlanes];       ///< target's axis_v
  rt::Vector3 turned_back_[kMostPlanes];  ///< target's centroids as the source's axes have them
  std::uint16_t source_of_[kMostCandidatePairs]{};
  std::uint16_t target_of_[kMostCandidatePairs]{};
  bool opposite_[kMostCandidatePairs]{};
  Overlap overlap_[kMostCandidatePairs]{};
  double worth_[kMostCandidatePairs]{};
  double gain_[kMostCandidatePairs]{};
  double offset_[kMostCandidatePairs]{};  ///< n_t . (c_t - scale R c_s): what n_t . t is at a match
  Tally tally_;
  Vote votes_[kMostCandidatePairs]{};
  std::uint32_t voted_{};
  double given_[3][3][kMostShiftPeaks][kMostShiftPeaks]{};  ///< gain_given(), or less than 0
  std::uint32_t others_[kMostCandidatePairs]{};             ///< pairs of no axis
  std::uint32_t other_count_{};
  double log_count_[kMostPlanes + 1]{};
  double sums_[kMostCandidatePairs + 1]{};  ///< of gains along an axis
  std::uint32_t first_[kMostPlanes + 1]{};  ///< pairs of source plane i: first_[i] .. first_[i + 1]
};

}  // namespace sortie::mapping
