// SPDX-License-Identifier: BSD-3-Clause
// Where a vehicle can come to rest at all, whatever lies in cells that are known between bounds only.
#pragma once

#include <array>
#include <cstdint>

#include "planner/posture.hpp"

namespace sortie::planner {

/// From least to most.
struct Range {
  double low{};
  double high{};
};

/// All rests within 0.7 rad of pitch and of roll that any ground within the cells' bounds allows lie in here;
/// not all that lies in here is one. Of steeper ones nothing is said.
struct PostureBounds {
  bool bounded{};  ///< false: so little is known that a rest at every tilt is possible; no number then
  bool rests{};    ///< false: no ground within the bounds carries it within 0.7 rad; no number then
  bool may_tip{};  ///< a rest at the end of the tilts looked at, 0.7 rad, is possible
  Range pitch_rad;
  Range roll_rad;
  Range height_m;              ///< of the body's origin, in the world
  double least_clearance_m{};  ///< under the belly; 0 where it may touch
  std::uint32_t units{};       ///< boxes of tilts that were tried
};

/// Branch and prune over pitch and roll. At a rest each sample that touches can be as high as the body's
/// underside is there, no sample must be higher, and those that touch surround the centre of mass. A box of
/// tilts is thrown out where intervals show that no ground within the bounds has all three; what is left is
/// cut in four, level by level, down to 0.4 degrees. What is left then is the answer, and after any number of
/// units one that holds.
///
/// It holds for ground that runs through the patch's samples as the posture has it, and for what GroundPatch
/// says of cells. No heap; about 75 kB, keep it off small stacks. Cost: 10-20 us a unit.
class PostureBounder {
 public:
  static constexpr double kWidest_rad = 0.7;  ///< of pitch and of roll
  static constexpr std::uint32_t kMostBoxes = 1024;

  /// The bounds where `solver` looked, in at most `units` units (196 to 4096; levels are done whole or not at
  /// all). Status: that of PostureSolver::looked(); out_of_range: other units. Nothing is written then.
  Status bound(const PostureSolver& solver, const FlipperSet& flippers, std::uint32_t units,
               PostureBounds& bounds);

 private:
  struct Box {
    double pitch_rad, roll_rad;
  };
  /// A stretch between two columns under a slice, and the most it can lift.
  struct Stretch {
    double x_m, y_m, off_y_m, most_m;
  };
  /// What a box of tilts allows.
  struct Verdict {
    bool possible{};
    double least_m{}, most_m{}, clearance_m{};
  };

  Verdict try_box(const Outline& outline, const GroundPatch& ground, const rt::Vector3& com, const Box& box,
                  double half_rad);

  std::array<Box, kMostBoxes> boxes_{};
  std::array<Box, kMostBoxes> next_{};
  rt::FixedVector<Stretch, kOutlineSlices*(GroundPatch::kColumns + 1)> stretches_;
};

}  // namespace sortie::planner
