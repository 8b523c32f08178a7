// SPDX-License-Identifier: BSD-3-Clause
// The incremental segmenter: keeps the connected components of a rolling grid's voxels exact while voxels
// come, move and go.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mapping/grid/reach.hpp"
#include "mapping/grid/rolling_grid.hpp"
#include "mapping/segments/fragment_graph.hpp"
#include "mapping/segments/labelling.hpp"
#include "mapping/segments/segmentation_policy.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Debug builds test the segmenter's invariants after every update of a map of at most so many blocks, until
/// a state is read: damaged bytes may show anything, as long as they lead nowhere outside.
#ifdef NDEBUG
inline constexpr std::uint32_t kBlocksChecked = 0;
#else
inline constexpr std::uint32_t kBlocksChecked = 64;
#endif

/// Settings of a segmenter.
struct SegmenterConfig {
  double radius_m{0.2};           ///< growing radius: more than 0, at most 4 voxels
  std::uint32_t min_voxels{100};  ///< from which a component gets an id; it keeps it when it shrinks
  std::uint32_t units{0};         ///< most work a tick; 0: all there is. See Segmenter::kBlockUnits

  SORTIE_KEYS(c, key) {
    key("growing_radius_m", c.radius_m, {0.001, 40, "m", "voxels this near are of one segment"});
    key("min_voxels", c.min_voxels, {1, 1e6, "voxels", "from which a segment gets an id"});
  }
};

/// What the segmenter knows of a block besides its fragments; what holds of it at any time stands in
/// segmenter_invariants.hpp. 24 bytes.
struct BlockWork {
  static constexpr std::uint32_t kAllMixed = (1u << kDirections) - 1;
  std::uint64_t moved{};           ///< voxels that changed since it was looked at
  std::uint64_t looked{};          ///< voxels that had changed when it was looked at
  std::uint32_t mixed{kAllMixed};  ///< bit n: it and the block in direction n may hold two components
  std::uint16_t slack{};           ///< drift until a link within it can break, in kDriftStep; 0: not known
  std::uint8_t queued : 2 {};      ///< 0: not; else a tag of the cycle that will look at it
  std::uint8_t renewed : 1 {};     ///< when it was looked at it got fresh fragments
  std::uint8_t wanting : 1 {};     ///< there was no room for one of its fragments or edges
  std::uint8_t cycle{};            ///< low bits of the cycle that looked at it
};
static_assert(sizeof(BlockWork) == 24);

/// Memory of a segmenter: value-initialised arrays.
struct SegmenterMemory {
  std::span<FragmentNode> nodes;  ///< about 1.5 a block; at most 65,534
  std::span<NodeIndex> first;     ///< one a block of the grid
  std::span<BlockIndex> queue;    ///< one a block
  std::span<BlockWork> work;      ///< one a block
  LabellingMemory labelling;
};

/// What one tick did and what it left to do.
struct SegmenterStep {
  std::uint32_t units{};    ///< of work done
  std::uint32_t blocks{};   ///< looked at again
  std::uint32_t backlog{};  ///< blocks that wait to be looked at
  std::uint32_t wanting{};  ///< blocks that lack fragments or edges until there is room for them
  bool current{};           ///< what is shown is the exact partition of the grid as it is now
  bool done{};  ///< the next update does nothing unless something changes. Not current: a pool is full
  SORTIE_FIELDS(units, blocks, backlog, wanting, current, done)
};

/// Incremental segmentation. What touches is kept as a graph of fragments (FragmentGraph), and labelled anew
/// as a whole (Labelling), so merges and splits are exact alike. Every voxel whose mean moved leads to exact
/// tests: of its block, of the edges that it makes, and of pairs of fragments that belong to two components.
/// New edges within a component change nothing and are not looked for, until known edges no longer hold it
/// together. With a budget the rest waits: blocks in a queue, the labelling where it stopped; no tick does
/// more than one block beyond it; what is shown meanwhile is the last finished labelling. Without input it
/// converges to the partition of the whole. A full pool leaves voxels without a segment, or segments apart;
/// that is not current. What was left out is tried again when there is room. No heap.
template <SegmentationPolicy Policy>
class Segmenter {
 public:
  static constexpr std::uint32_t kBlockUnits = 32;  ///< of work that looking at a block counts as

  /// `voxel_size_m` of the grid. A radius beyond 4 voxels or a lack of memory makes a segmenter that does
  /// nothing: see status().
  Segmenter(const SegmenterConfig& config, double voxel_size_m, const Policy& policy,
            const SegmenterMemory& memory)
      : config_(config),
        policy_(policy),
        reach_(config.radius_m / voxel_size_m),
        graph_(memory.nodes, memory.first),
        labelling_(config.min_voxels, memory.labelling),
        queue_(memory.queue),
        work_(memory.work),
        status_(check(config, voxel_size_m, memory)) {}

  /// ok, or out_of_range: the radius, or arrays too short for one another.
  Status status() const { return status_; }

  /// Active voxels of a block that are new, moved or otherwise changed: it must be looked at again. `drift`:
  /// no two of them came apart by more, in steps of kDriftStep, and nothing else that the policy reads of
  /// them changed; kAnyDrift where that is not known.
  void mark(BlockIndex block, std::uint64_t moved, std::uint16_t drift = kAnyDrift);
  /// A block that is about to be given back; its voxels and its place can still be read.
  void forget(const RollingGrid& grid, BlockIndex block);
  /// Works off what was marked, within the budget.
  SegmenterStep update(const RollingGrid& grid, std::uint32_t tick);

  /// Segment of an active voxel; kNoSegment where it is too small, or new since the labelling that is shown.
  /// A voxel that is no core costs a search around it.
  SegmentId segment_of(const RollingGrid& grid, BlockIndex block, unsigned cell) const {
    const NodeIndex node = graph_.holder(block, cell);
    if (node != kNoNode) return labelling_.id(graph_[node].label[labelling_.shown()]);
    if constexpr (TakingPolicy<Policy>) return taken_in(grid, block, cell);
    return kNoSegment;
  }
  /// Segments, ids, fragments with their edges and the blocks that wait, to bytes and back, after the grid:
  /// what was read goes on as what was written would have. Only a labelling that is under way begins anew.
  /// Between scans, at any step of the work.
  void archive(rt::Archive& archive, const RollingGrid& grid);
  /// Which of the invariants in segmenter_invariants.hpp does not hold, in a few words; null where all hold.
  /// Between steps, after mark(). Tests every pair of voxels around every block: for tests and debug builds.
  const char* broken(const RollingGrid& grid) const;

  const Labelling& labelling() const { return labelling_; }
  const FragmentGraph& graph() const { return graph_; }
  const Policy& policy() const { return policy_; }

 private:
  struct Here;
  struct Beside;
  struct Pairs;
  struct Own;
  void archive_work(rt::Archive& archive, const RollingGrid& grid, std::uint32_t blocks);
  void archive_queue(rt::Archive& archive, std::uint32_t blocks);
  static Status check(const SegmenterConfig& config, double voxel_size_m, const SegmenterMemory& memory) {
    const double cells = config.radius_m / voxel_size_m;
    const bool radius = cells > 0 && cells <= Reach::kMostCells;
    const std::size_t nodes = memory.nodes.size();
    const LabellingMemory& l = memory.labelling;
    const bool room = nodes > 0 && !memory.first.empty() && memory.queue.size() >= memory.first.size() &&
                      memory.work.size() >= memory.first.size() && l.work.size() >= nodes &&
                      l.components.size() >= nodes && l.fresh.size() >= nodes && !l.slots.empty();
    return radius && room ? Status::ok : Status::out_of_range;
  }
  SegmentId taken_in(const RollingGrid& grid, BlockIndex block,
                     unsigned cell) const requires TakingPolicy<Policy>;
  static std::uint8_t tag(std::uint32_t cycle) { return static_cast<std::uint8_t>(1 + (cycle & 1)); }
  void enqueue(BlockIndex block);
  void want(BlockIndex block);
  void want_no_more(BlockIndex block);
  std::uint32_t sweep();
  const char* broken_block(const RollingGrid& grid, BlockIndex block) const;
  const char* broken_pair(const RollingGrid& grid, BlockIndex a, BlockIndex b, int direction) const;
  bool awaits(BlockIndex a, std::uint64_t cells, BlockIndex b) const;
  void look_at(const RollingGrid& grid, BlockIndex block);
  std::uint16_t slack_of(std::int64_t longest) const;
  void fragment(const RollingGrid& grid, Here& here);
  void join_parts(const RollingGrid& grid, Here& here);
  void find_parts(const RollingGrid& grid, Here& here);
  void renew_nodes(const RollingGrid& grid, Here& here);
  void set_cells(NodeIndex node, std::uint64_t cells);
  void drop(const RollingGrid& grid, BlockIndex block, NodeIndex node);
  void ask(const RollingGrid& grid, BlockIndex block, std::uint32_t directions,
           BlockIndex (&around)[kDirections]) const;
  bool are_mixed(BlockIndex a, BlockIndex b) const;
  void survey(const RollingGrid& grid, const Here& here, const BlockIndex (&around)[kDirections],
              Pairs& pairs);
  void look_from(const RollingGrid& grid, const Here& here, const Beside& beside, NodeIndex node,
                 bool renewed);
  void keep_edges(const RollingGrid& grid, const Here& here, const Pairs& pairs);
  void rejoin(const RollingGrid& grid, NodeIndex apart);
  Own own_voxel(const RollingGrid& grid, const Here& here, const Beside& beside, unsigned cell) const;
  bool test(const RollingGrid& grid, const Beside& beside, const Own& own, unsigned b) const;
  void verify(const RollingGrid& grid, const Here& here, const Beside& beside, NodeIndex keeper,
              NodeIndex part, unsigned i);
  void search(const RollingGrid& grid, const Here& here, const Beside& beside, NodeIndex node,
              std::uint64_t open, bool all);
  std::uint64_t joined(const Beside& beside, NodeIndex node) const;

  SegmenterConfig config_;
  Policy policy_;
  Reach reach_;
  FragmentGraph graph_;
  Labelling labelling_;
  std::span<BlockIndex> queue_;
  std::span<BlockWork> work_;
  Status status_;
  std::uint32_t queue_first_{};
  std::uint32_t queue_size_{};
  std::uint32_t cycle_{};
  std::uint32_t left_of_cycle_{};  ///< blocks that are looked at before the next labelling
  bool changed_{};                 ///< the graph, since the newest labelling began
  bool drained_{};                 ///< a cycle is done, its labelling comes next
  bool swept_{};                   ///< before the next cycle blocks that want room were looked for
  std::uint32_t sweep_left_{};     ///< block numbers to look through for them
  std::uint32_t wanting_{};        ///< blocks that want room
  bool read_{};                    ///< a state came from bytes
};

}  // namespace sortie::mapping

#include "mapping/segments/segmenter_edges.hpp"       // IWYU pragma: export
#include "mapping/segments/segmenter_engine.hpp"      // IWYU pragma: export
#include "mapping/segments/segmenter_fragments.hpp"   // IWYU pragma: export
#include "mapping/segments/segmenter_invariants.hpp"  // IWYU pragma: export
#include "mapping/segments/segmenter_state.hpp"       // IWYU pragma: export
