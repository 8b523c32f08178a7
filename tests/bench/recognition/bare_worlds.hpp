// SPDX-License-Identifier: BSD-3-Clause
// Worlds with few things or none: corridors and empty halls, visited again or never kept.
#pragma once

#include "tests/bench/recognition/deceptive_worlds.hpp"

namespace sortie::bench {

/// What they are.
enum class BareKind {
  corridor,  ///< straight, 30 to 44 m; niches and doors that stand back, nowhere alike
  bend,      ///< two such corridors of 18 to 26 m at a right angle
  hall,      ///< 16 to 30 m by 10 to 18 m, pilasters on its walls and nothing else
  pillars,   ///< such a hall with four to nine pillars that stand anywhere
  winding,   ///< a tunnel of 30 to 44 m whose two walls wind, each as it likes, without an edge anywhere
  plain      ///< a straight corridor without anything, but for its ends
};
inline constexpr BareKind kBareKinds[] = {BareKind::corridor, BareKind::bend,    BareKind::hall,
                                          BareKind::pillars,  BareKind::winding, BareKind::plain};
const char* name_of(BareKind kind);

/// What the robot's place is to what was kept.
enum class BareTruth {
  along,     ///< the same, the second way in the direction of the first one, from another start
  against,   ///< the other way round
  another,   ///< another one of the same size, with other niches, pilasters, pillars: never kept
  mirrored,  ///< its mirror image: never kept
  twins      ///< two that are the same in everything were kept; the robot is in one of them
};
inline constexpr BareTruth kBareTruths[] = {BareTruth::along, BareTruth::against, BareTruth::another,
                                            BareTruth::mirrored, BareTruth::twins};
const char* name_of(BareTruth truth);

/// The same for the same draws.
RecognitionWorld bare_world(BareKind kind, BareTruth truth, testing::Draws& draws);

}  // namespace sortie::bench
