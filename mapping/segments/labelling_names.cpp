// SPDX-License-Identifier: BSD-3-Clause
// Which component goes on as which segment: the votes of its voxels, the ids that go on, are new, or end.
#include <algorithm>

#include "mapping/segments/labelling.hpp"

namespace sortie::mapping {

/// The next node of a component gives its voxels to the segment that it was of.
void Labelling::vote(const FragmentGraph& graph) {
  const auto component = static_cast<std::uint16_t>(at_);
  const NodeIndex node = vote_node_;
  vote_node_ = memory_.work[node].next;
  if (vote_node_ == kNoNode && ++at_ < components_) vote_node_ = memory_.components[at_].first;
  const std::uint16_t label = graph[node].label[shown_];
  if (graph[node].cells == 0 || label == kNoLabel) return;
  SegmentComponent& c = memory_.components[component];
  SegmentSlot& slot = memory_.slots[label];
  if (c.cut_from == kNoLabel || slot.id < memory_.slots[c.cut_from].id) c.cut_from = label;
  if (slot.looked != component) {
    close_vote(slot);
    slot.looked = component;
    slot.here = 0;
  }
  slot.here += graph[node].voxels;
}

void Labelling::close_vote(SegmentSlot& slot) {
  if (slot.here == 0) return;
  const bool more = slot.here > slot.most;
  const bool tie =
      slot.here == slot.most && memory_.components[slot.looked].key < memory_.components[slot.owner].key;
  if (more || tie) {
    slot.most = slot.here;
    slot.owner = slot.looked;
  }
  slot.here = 0;
}

void Labelling::go(const SegmentSlot& slot) {
  ++making_.gone;
  ++leaving_;
  event(SegmentChange::gone, slot.id, kNoSegment);
}

/// Of the segments that stay with a component the oldest one names it.
void Labelling::decide(std::uint16_t index) {
  const SegmentSlot& slot = memory_.slots[index];
  if (slot.most == 0) return go(slot);
  std::uint16_t& named = memory_.components[slot.owner].slot;
  if (named == kNoLabel || slot.id < memory_.slots[named].id) named = index;
}

/// Components that need a new id line up by key.
void Labelling::queue(std::uint16_t component) {
  const SegmentComponent& c = memory_.components[component];
  if (c.slot != kNoLabel || c.voxels < min_voxels_) return;
  memory_.fresh[fresh_++] = component;
  std::ranges::push_heap(memory_.fresh.first(fresh_), later());
}

void Labelling::name(std::uint16_t component) {
  const auto size = static_cast<std::uint32_t>(memory_.slots.size());
  while (slot_hand_ < slot_numbers_ && memory_.slots[slot_hand_].id != kNoSegment) ++slot_hand_;
  // Ids never come again: one may live on for ever, and its age is its number. So at last none is left.
  const std::uint64_t id = next_id_ + making_.born;
  if (slot_hand_ == size || id >= kIdsSpent) {
    ++making_.slots_full;
    ++nameless_;
    return;
  }
  if (slot_hand_ == slot_numbers_) ++slot_numbers_;
  SegmentComponent& c = memory_.components[component];
  c.slot = static_cast<std::uint16_t>(slot_hand_);
  memory_.slots[slot_hand_] = SegmentSlot{};
  memory_.slots[slot_hand_].id = static_cast<SegmentId>(id);
  memory_.slots[slot_hand_].first_tick = tick_;
  memory_.slots[slot_hand_].most = c.voxels;
  memory_.slots[slot_hand_].owner = component;
  const bool cut = c.cut_from != kNoLabel;
  ++making_.born;
  if (cut) ++making_.cut;
  event(SegmentChange::born, memory_.slots[slot_hand_].id, cut ? memory_.slots[c.cut_from].id : kNoSegment);
}

}  // namespace sortie::mapping
