// SPDX-License-Identifier: BSD-3-Clause
// Segments as they are tracked: ids that live on through merges and splits, and what happened to them.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/segments/fragment_graph.hpp"
#include "rt/segment_list.hpp"

namespace sortie::mapping {

using SegmentId = std::uint32_t;
inline constexpr SegmentId kNoSegment = 0;
using rt::SegmentChange;
using rt::SegmentEvent;

/// A segment's place in the table. `voxels` and `first_tick` are what a reader wants, the rest is scratch of
/// the next labelling.
struct SegmentSlot {
  SegmentId id{};  ///< kNoSegment: free
  std::uint32_t first_tick{};
  std::uint32_t voxels[2]{};  ///< of the shown labelling and of the one in the making
  std::uint32_t most{};       ///< voxels of the component that holds most of it
  std::uint32_t here{};       ///< voxels of it in the component that is being looked at
  std::uint16_t owner{};      ///< component that holds most of it
  std::uint16_t looked{};     ///< component that is being looked at
};

/// A connected component in the making: 24 bytes.
struct SegmentComponent {
  std::uint64_t key{};  ///< smallest block and cell: names the component whatever order things came in
  std::uint32_t voxels{};
  NodeIndex first{kNoNode};
  std::uint16_t slot{kNoLabel};
  std::uint16_t cut_from{kNoLabel};  ///< slot of the oldest segment that its nodes had
};

/// Scratch of a node: 6 bytes.
struct NodeWork {
  NodeIndex parent{};
  std::uint16_t component{};  ///< of a root; before, of a name, what is left of the votes for its root
  NodeIndex next{kNoNode};  ///< of the same component; before, of a name, the root that has most of its nodes
};

}  // namespace sortie::mapping
