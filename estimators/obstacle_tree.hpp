// SPDX-License-Identifier: BSD-3-Clause
// Small decision trees over what was felt lately: which idea of the contact fits, how well, and its name.
#pragma once

#include <cstdint>

namespace sortie::estimators {

/// Ideas of how the body moves along its normal while it turns by w. Most name the place on the lower run
/// that does not move along the normal; the direction of travel is forward (a robot that backs up looks
/// backwards). What a leaf of a tree says.
enum class PivotIdea : std::uint8_t {
  middle,         ///< the body follows its own axis, as on a plane
  rear,           ///< the end of the run behind stays where it touches the plane that was left
  rear_carries,   ///< the rear end rolls on that plane, an edge under the run carries, too: pivot_on_run
  edge,           ///< about the foremost edge that came under the run
  balance,        ///< about the edge under the centre of mass, followed since
  front,          ///< as rear, in front
  front_carries,  ///< as rear_carries, in front
  rear_rolls,     ///< the rear end rolls on the plane that was left, whatever the front does
  rear_base,      ///< the same for the last plane that was driven on for long
  front_base,     ///< the front end rolls on a plane parallel to that
  fixed,          ///< about a place that training found
};
inline constexpr std::uint32_t kPivotIdeas = 11;

/// Ideas of the same across the body, for roll.
enum class SideIdea : std::uint8_t { middle, lower, higher };

/// What the tree may ask. Lengths in m, angles in rad, the direction of travel is forward.
enum class ModeFeature : std::uint8_t {
  curvature,       ///< nose up per metre of belt, over the last centimetre
  slow_curvature,  ///< over the last five
  tilt,            ///< to the plane that was left
  pitch,           ///< to the horizontal
  turned,          ///< since this rise or fall began
  travelled,       ///< since then
  share,           ///< curvature to its largest of this rise
  steady,          ///< travel without turning before it
  edge,            ///< foremost edge under the run; 1 if none
  last_edge,       ///< rearmost; 1 if none
  rolls,           ///< pivot of rear_carries before it is limited to the run
  rate,            ///< nose up per second
  roll_curvature,  ///< away from level per metre
  roll,            ///< to the horizontal
  front_flipper,   ///< angle of the leading flippers
  rear_flipper,    ///< of the trailing ones
  base_tilt,       ///< to the last plane that was driven on for long
  steady_now,      ///< travel without turning until now
  away,            ///< travel since the last plane that was driven on for long: below a robot's length, its
                   ///< rear end is still there
  rise_ago,        ///< travel since the last rise began
  fall_ago,        ///< and since the last fall
  last_turn,       ///< nose up by the last rise or fall that is over
  long_curvature,  ///< nose up per metre over the last fifteen centimetres
};
inline constexpr std::uint32_t kModeFeatures = 23;

/// A node of a tree that lies in the order of a walk. It asks feature < bound and goes on at the next node,
/// else at `no`. A leaf has no = 0.
struct TreeNode {
  std::uint8_t what{};  ///< the feature; of a leaf the idea, in a tree of names the mode
  std::uint16_t no{};
  float value{};    ///< the bound; of a leaf the place of the idea `fixed`
  float sigma_m{};  ///< of a leaf: rms of what the idea missed in training, per rad of turn
  float sigma{};    ///< the same per metre of travel
};

/// Longest way down: bounds the time of a decision.
inline constexpr std::uint32_t kTreeDepth = 8;

/// Every way down from `at` ends at a leaf within `depth` questions.
constexpr bool ends_within(const TreeNode* tree, std::uint32_t depth, std::uint32_t at = 0) {
  const TreeNode& node = tree[at];
  return node.no == 0 ||
         (depth > 0 && ends_within(tree, depth - 1, at + 1) && ends_within(tree, depth - 1, node.no));
}

/// Walks down a tree that ends within kTreeDepth. Cost: at most kTreeDepth comparisons.
inline const TreeNode& decide(const TreeNode* tree, const double (&features)[kModeFeatures]) {
  const TreeNode* node = tree;
  for (std::uint32_t i = 0; i < kTreeDepth && node->no != 0; ++i)
    node = features[node->what] < static_cast<double>(node->value) ? node + 1 : tree + node->no;
  return *node;
}

}  // namespace sortie::estimators
