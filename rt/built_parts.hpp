// SPDX-License-Identifier: BSD-3-Clause
// What this build has. A build of one scene (-DSORTIE_SCENE=name) leaves out the code of the parts that the
// scene does not name; every other build has all of them.
#pragma once

#include <cstdint>

#ifdef SORTIE_ONE_SCENE
#include "sortie_scene_build.hpp"  // written by the build from the scene's profile
#endif

namespace sortie::rt {

/// A part whose code can be left out. The names that profiles and commands know them by are in
/// firmware_like/scene/scene_parts.cpp.
enum class Part : std::uint8_t {
  ugv,
  attitude,
  odometry,
  obstacles,
  drive,
  flippers,
  canopen,
  odrive,
  map,
  segments,
  normals,
  segment_lists,
  ssl,
  ray_scheduler,
  uav,
  pilot,
  path,
  sensed_map,
  telemetry,
  recorder,
  count  ///< of parts; none itself
};

/// One bit a part, the first is bit 0.
using PartMask = std::uint32_t;
constexpr PartMask mask_of(Part part) { return PartMask{1} << static_cast<unsigned>(part); }

#ifdef SORTIE_ONE_SCENE
inline constexpr PartMask kBuiltParts = kSceneParts;
/// The scene that this program was built for; empty: for all.
inline constexpr const char* kOnlyScene = kSceneName;
#else
inline constexpr PartMask kBuiltParts = mask_of(Part::count) - 1;
inline constexpr const char* kOnlyScene = "";
#endif

/// True where the code of `part` is in this build. A constant: what it guards is no code otherwise, so that
/// the linker never hears of it.
template <Part part>
inline constexpr bool kBuilt = (kBuiltParts & mask_of(part)) != 0;

/// The same for a part that is known when the program runs.
constexpr bool is_built(Part part) { return (kBuiltParts & mask_of(part)) != 0; }

}  // namespace sortie::rt
