// SPDX-License-Identifier: BSD-3-Clause
// What the program of one scene weighs, whole and with one part left out: measured from builds, for the table
// of costs.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace sortie::firmware {

/// One build: -DSORTIE_SCENE of that scene, on x86-64 by the preset release.
struct PartSize {
  const char* scene;
  const char* without;  ///< the part that was left out, or ""
  std::uint64_t bytes;  ///< code, constants and initialised data
};

/// All that were built. Written by `toolchain/scene-builds --parts`.
std::span<const PartSize> part_sizes();

/// Bytes of the program of `scene` without `part` ("": with all of its parts). A part that shares its
/// parent's code weighs nothing by itself, so that is the whole program. 0: nobody built it.
std::uint64_t program_bytes(std::string_view scene, std::string_view part);

}  // namespace sortie::firmware
