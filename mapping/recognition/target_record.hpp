// SPDX-License-Identifier: BSD-3-Clause
// What is kept of a segment that was seen: 64 bytes.
#pragma once

#include <cstdint>

#include "mapping/recognition/key_frame.hpp"
#include "mapping/recognition/segment_descriptor.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// Number of a target in its store.
using TargetIndex = std::uint16_t;
inline constexpr TargetIndex kNoTarget = 0xffff;

/// A complete view of a segment, as it is handed to the store.
struct TargetSighting {
  std::uint32_t id{};        ///< of the segment, as its robot numbers them
  std::uint32_t stamp_ms{};  ///< of the view; wraps after 49 days
  std::uint32_t voxels{};
  std::uint16_t key_frame{};  ///< number in the store's table
  std::uint16_t version{};    ///< of the segment; wraps
  std::uint8_t robot{};
  PlaceCm offset;  ///< of its centroid from the key frame, in that frame, turned by its heading
  SegmentDescriptor descriptor;
};

enum class TargetState : std::uint8_t {
  free = 0,
  kept,
};

/// A target. Its place follows its key frame: a correction of key frames changes no record.
struct TargetRecord {
  /// `uniqueness` where no other descriptor is so near; such a target has no `nearest`.
  static constexpr std::uint8_t kMostUnique = 255;

  SegmentDescriptor descriptor;  ///< first: it is read with whole words
  std::uint32_t id{};
  std::uint32_t voxels{};
  std::uint32_t last_seen_ms{};
  std::uint32_t edition{};  ///< counts up when anything but the uniqueness of the place in the store changes
  PlaceCm offset;           ///< from the key frame
  std::uint16_t key_frame{};
  std::uint16_t version{};         ///< of the latest view
  std::uint16_t views{};           ///< stays at 65,535
  TargetIndex nearest{kNoTarget};  ///< the other target whose descriptor is nearest
  std::uint8_t robot{};
  std::uint8_t uniqueness{};  ///< distance of that descriptor, at most 255; 0 until it is known
  TargetState state{TargetState::free};

  SORTIE_FIELDS(descriptor, id, voxels, last_seen_ms, edition, offset, key_frame, version, views, nearest,
                robot, uniqueness, state)
};
static_assert(sizeof(TargetRecord) == 64);

}  // namespace sortie::mapping
