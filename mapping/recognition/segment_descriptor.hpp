// SPDX-License-Identifier: BSD-3-Clause
// What a segment looks like in 24 bytes, and how unlike two of them are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// Shape of a segment that turning it about the vertical and moving it leave as it is. Whole steps of one
/// byte, so that it is compared in whole numbers and sent as it is stored. All parts change steadily with the
/// voxels: what jumps where axes or bins change their order is damped to nothing there. A mirror image
/// has the same descriptor. It describes what is in the map: of a body that was seen from one side only, that
/// side. segment_shape.hpp makes it. 24 bytes.
struct SegmentDescriptor {
  static constexpr unsigned kSteps = 24;
  static constexpr unsigned kBins = 8;
  // Where the parts begin.
  static constexpr unsigned kSize = 0;     ///< 3: spread along the principal axes, longest first, logarithmic
  static constexpr unsigned kUpright = 3;  ///< 2: how upright the two longer axes are, 0 .. 64
  static constexpr unsigned kThird = 5;    ///< 2: third moments along them, about 128
  static constexpr unsigned kFill = 7;    ///< voxels to the volume of the box of the same spread, logarithmic
  static constexpr unsigned kHeight = 8;  ///< 8: share of the voxels by height, of 128
  static constexpr unsigned kRadius = 16;  ///< 8: by distance from the upright through the middle, of 128

  std::uint8_t step[kSteps]{};
  bool operator==(const SegmentDescriptor&) const = default;
  SORTIE_FIELDS(step)
};
static_assert(sizeof(SegmentDescriptor) == 24);

/// How many times the two longer sizes count: between two visits of a segment they move by 1 to 3 steps and
/// the histogram of distances by 27 to 41, so each alike would drown what tells most. Chosen on halls other
/// than those that the benchmark draws (`sortie bench recognition --only descriptors`).
inline constexpr std::int32_t kSizeWeight = 8;

/// Sum of the differences of all steps, the two longer sizes kSizeWeight times: 0 .. 9,690. Two loops of
/// whole vectors of bytes: gcc makes two psadbw (or their like) of them at -O2. About 1 ns.
inline std::uint32_t difference(const SegmentDescriptor& a, const SegmentDescriptor& b) {
  std::int32_t sum = 0;
  for (unsigned i = 0; i < 16; ++i) sum += std::abs(a.step[i] - b.step[i]);
  for (unsigned i = 16; i < 24; ++i) sum += std::abs(a.step[i] - b.step[i]);
  constexpr unsigned k = SegmentDescriptor::kSize;
  sum += (kSizeWeight - 1) * (std::abs(a.step[k] - b.step[k]) + std::abs(a.step[k + 1] - b.step[k + 1]));
  return static_cast<std::uint32_t>(sum);
}

/// Gate before difference(): whether all three sizes agree within so many steps, 16 to a factor of two.
inline bool same_sizes(const SegmentDescriptor& a, const SegmentDescriptor& b, std::int32_t within) {
  constexpr unsigned k = SegmentDescriptor::kSize;
  const std::int32_t most =
      std::max({std::abs(a.step[k] - b.step[k]), std::abs(a.step[k + 1] - b.step[k + 1]),
                std::abs(a.step[k + 2] - b.step[k + 2])});
  return most <= within;
}

}  // namespace sortie::mapping
