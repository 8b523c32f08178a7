// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/part_sizes.hpp"
#include "firmware_like/scene_parts.hpp"

namespace sortie::firmware {

std::uint64_t program_bytes(std::string_view scene, std::string_view part) {
  const ScenePart* const known = find_scene_part(std::string(part));
  const std::string_view built =
      known != nullptr && known->code == rt::Part::count ? std::string_view() : part;
  for (const PartSize& size : part_sizes()) {
    if (size.scene == scene && size.without == built) return size.bytes;
  }
  return 0;
}

}  // namespace sortie::firmware
