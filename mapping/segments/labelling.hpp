// SPDX-License-Identifier: BSD-3-Clause
// From the graph of fragments to segments with ids: connected components, exactly, in steps that can stop
// after any of them.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/segments/fragment_graph.hpp"
#include "mapping/segments/segment_table.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// Memory of a labelling: value-initialised arrays.
struct LabellingMemory {
  std::span<NodeWork> work;                ///< one a node
  std::span<SegmentComponent> components;  ///< one a node
  std::span<std::uint16_t> fresh;          ///< one a node
  std::span<SegmentSlot> slots;            ///< most segments at a time, at most 65,534
  std::span<SegmentEvent> events;          ///< twice the most events of a labelling
};

/// What happened to segments since start, by kind.
struct SegmentEventCounts {
  std::uint64_t born{};
  std::uint64_t renamed{};
  std::uint64_t gone{};
  std::uint64_t cut{};  ///< of those that were born, the ones that were cut from another
  SORTIE_FIELDS(born, renamed, gone, cut)
};

/// Counters of all labellings that were finished.
struct LabellingCounts : SegmentEventCounts {
  std::uint64_t labellings{};  ///< finished ones
  std::uint64_t slots_full{};  ///< components that got no id for want of a slot, or of an id
  std::uint64_t events_lost{};
  SORTIE_FIELDS(labellings, born, renamed, gone, cut, slots_full, events_lost)
};

/// One labelling after the other over a graph. Rules: a segment stays with the component that holds most of
/// its voxels (a tie: the one with the smallest key); a component takes the oldest of the ids that stay with
/// it, the others are renamed to it; a component without an id gets a new one when it has `min_voxels`, in
/// the order of keys. So ids do not depend on the order in which voxels came. What readers see changes only
/// when a labelling is finished, counters too. Cost: about 10 visits a node, each of constant cost but for
/// the union-find (nearly so) and a heap of the components that get new ids.
///
/// The owner of the graph need not know all edges within a component, as long as it knows enough of them to
/// hold it together. When edges went and a component falls apart by those that are known, the labelling asks
/// for the nodes of all parts but the largest one, one after the other (apart()), so that the owner can look
/// for edges that it did not know; then it goes on.
///
/// Between two steps the owner may give nodes back, after leaving() said so. A labelling under way then shows
/// what is gone as long as it takes to make the next one; no segment goes without an event.
class Labelling {
 public:
  Labelling(std::uint32_t min_voxels, const LabellingMemory& memory);

  /// True while a labelling is under way: the graph must hold its nodes.
  bool running() const { return stage_ != Stage::idle; }
  /// A node that known edges no longer join with the most of its component, or kNoNode. The labelling waits
  /// until the owner has joined() what touches it and calls checked().
  NodeIndex apart() const { return apart_; }
  void checked() { apart_ = kNoNode; }
  /// All nodes of a block are about to be given back. Nobody need check them.
  void leaving(const FragmentGraph& graph, BlockIndex block);
  /// Two nodes touch after all; whether two nodes hang together by the edges known so far.
  void joined(NodeIndex a, NodeIndex b) { unite(a, b); }
  bool together(NodeIndex a, NodeIndex b) { return root(a) == root(b); }
  void start(std::uint32_t tick);
  /// Does at most `units` steps of the labelling; gives the steps that were used.
  std::uint32_t run(FragmentGraph& graph, std::span<const Block> blocks, std::uint32_t units);

  /// Which of a node's two labels is shown.
  unsigned shown() const { return shown_; }
  /// Segment of a shown label.
  SegmentId id(std::uint16_t label) const { return label == kNoLabel ? kNoSegment : memory_.slots[label].id; }
  /// Slots 0 .. slots().size() - 1; one is a segment when voxels[shown()] > 0.
  std::span<const SegmentSlot> slots() const { return memory_.slots.first(slot_numbers_); }
  /// Events of the newest labelling, once it is finished; until then those of the one before.
  std::span<const SegmentEvent> events() const {
    return memory_.events.subspan(shown_ * half(), shown_events_);
  }
  const LabellingCounts& counts() const { return counts_; }
  /// Components that should have an id by the labelling that is shown and have none: there was no slot.
  std::uint32_t nameless() const { return shown_nameless_; }
  /// Whether another labelling of the same graph would find slots for some of them.
  bool finds_slots() const { return shown_nameless_ > 0 && leaving_ > 0; }
  /// Before the graph is stored while its nodes' names are being written: writes the rest of them. Of a graph
  /// with names of two labellings nobody could say what fell apart since.
  void finish_names(FragmentGraph& graph) const;
  /// Ids and segments to bytes and back. A labelling that is under way is not kept: it begins anew.
  void archive(rt::Archive& archive);
  std::uint32_t components() const { return shown_components_; }

 private:
  enum class Stage : std::uint8_t {
    idle,
    reset,
    unite,
    survey,
    repair,
    reset_slots,
    group,
    vote,
    close,
    decide,
    rename,
    queue,
    name,
    write,
    settle
  };
  static constexpr SegmentId kIdsSpent = 0xffffffffu;  ///< the first number that is no id

  std::size_t half() const { return memory_.events.size() / 2; }
  NodeIndex root(NodeIndex node);
  void unite(NodeIndex a, NodeIndex b);
  std::uint32_t run_stage(FragmentGraph& graph, std::span<const Block> blocks, std::uint32_t room);
  void unite_around(const FragmentGraph& graph, NodeIndex node);
  void survey(NodeIndex node, NodeIndex name);
  void visit_slot(std::uint16_t slot);
  void group(const FragmentNode& node, std::uint64_t key);
  void vote(const FragmentGraph& graph);
  void close_vote(SegmentSlot& slot);
  void go(const SegmentSlot& slot);
  void decide(std::uint16_t slot);
  void name(std::uint16_t component);
  void queue(std::uint16_t component);
  void write(FragmentNode& node, NodeIndex index);
  void publish();
  void event(SegmentChange change, SegmentId id, SegmentId other);
  /// Order of the heap: the component with the smallest key comes out first.
  auto later() const {
    return [this](std::uint16_t a, std::uint16_t b) {
      return memory_.components[a].key > memory_.components[b].key;
    };
  }
  /// Goes on to a stage; gives where the last one came to.
  std::uint32_t next(Stage stage) {
    const std::uint32_t at = at_;
    stage_ = stage;
    at_ = 0;
    return at;
  }

  std::uint32_t min_voxels_;
  LabellingMemory memory_;
  Stage stage_{Stage::idle};
  unsigned shown_{};
  std::uint32_t at_{};
  std::uint32_t tick_{};
  std::uint32_t nodes_{};  ///< as many as there were when the labelling began
  NodeIndex vote_node_{kNoNode};
  NodeIndex apart_{kNoNode};
  bool fallen_apart_{};  ///< a component has two roots
  std::uint32_t components_{};
  std::uint32_t shown_components_{};
  std::uint32_t fresh_{};
  std::uint32_t slot_numbers_{};
  std::uint32_t slot_hand_{};
  std::uint32_t events_{};
  std::uint32_t shown_events_{};
  std::uint32_t nameless_{};  ///< of the labelling in the making
  std::uint32_t shown_nameless_{};
  std::uint32_t leaving_{};  ///< slots that the next labelling finds free
  bool disturbed_{};         ///< nodes left since the labelling began
  SegmentId next_id_{1};     ///< of the next labelling's first; kIdsSpent: there is none any more
  LabellingCounts counts_;
  LabellingCounts making_;  ///< of the labelling in the making
};

}  // namespace sortie::mapping
