// SPDX-License-Identifier: BSD-3-Clause
// Segments and fragments to bytes and back.
#include <algorithm>

#include "mapping/fragment_graph.hpp"
#include "mapping/labelling.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kFormatVersion = 1;
}  // namespace

void Labelling::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "segments")
      .fixed(min_voxels_, memory_)
      .scratch(stage_, at_, tick_, nodes_, vote_node_, apart_, fallen_apart_, components_, fresh_, slot_hand_,
               events_, shown_events_)
      .by_hand(slot_numbers_, shown_)
      .state(shown_components_, next_id_, counts_);
  archive.expect(kFormatVersion, "the segments have another format version");
  archive.bounded(slot_numbers_, memory_.slots.size());
  archive.bounded(shown_, 1);
  for (SegmentSlot& slot : memory_.slots.first(slot_numbers_)) {
    archive.value(slot.id);
    archive.value(slot.first_tick);
    archive.value(slot.voxels);
  }
  if (!archive.is_reading()) return;
  stage_ = Stage::idle;
  apart_ = kNoNode;
  events_ = shown_events_ = 0;
}

void FragmentGraph::archive(rt::Archive& archive, std::span<const Block> blocks, unsigned shown,
                            std::uint32_t slots) {
  const bool reading = archive.is_reading();
  rt::Members(archive, *this, "fragments")
      .fixed(nodes_, first_)
      .by_hand(numbers_, in_use_, free_)
      .scratch(waiting_, last_waiting_, held_)
      .state(most_in_use_, refused_);
  if (reading) {
    numbers_ = in_use_ = 0;
    free_ = waiting_ = last_waiting_ = kNoNode;
    std::fill(first_.begin(), first_.end(), kNoNode);
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto block = static_cast<BlockIndex>(i);
    std::uint32_t parts = 0;
    for (NodeIndex node = first_[block]; node != kNoNode; node = nodes_[node].next) ++parts;
    archive.bounded(parts, Block::kCells);
    NodeIndex node = first_[block];
    NodeIndex last = kNoNode;
    std::uint64_t seen = 0;
    for (std::uint32_t k = 0; k < parts; ++k) {
      std::uint64_t cells = reading ? 0 : nodes_[node].cells;
      std::uint16_t label = reading ? kNoLabel : nodes_[node].label[shown];
      archive.value(cells);
      archive.value(label);
      if (!reading) {
        node = nodes_[node].next;
        continue;
      }
      const bool fits = cells != 0 && blocks[i].in_use() && (cells & ~blocks[i].active) == 0 &&
                        (cells & seen) == 0 && (label == kNoLabel || label < slots);
      const NodeIndex fresh = fits ? take(block, cells) : kNoNode;
      if (fresh == kNoNode) return archive.fail(Status::malformed, "fragments that are not of this map");
      seen |= cells;
      nodes_[fresh].label[shown] = label;
      if (last == kNoNode) {
        first_[block] = fresh;
      } else {
        nodes_[last].next = fresh;
      }
      last = fresh;
    }
  }
}

}  // namespace sortie::mapping
