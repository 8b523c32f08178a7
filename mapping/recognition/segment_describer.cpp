// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/segment_describer.hpp"

#include <algorithm>
#include <cstdlib>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr std::int32_t kStepsOfBlock = 1024;
constexpr double kStepsOfCell = 256.0;

std::int32_t whole(double value) { return static_cast<std::int32_t>(rt::floor(value)); }
}  // namespace

SegmentDescriber::SegmentDescriber(std::uint32_t segments, std::uint32_t chosen, rt::Arena& arena)
    : moments_(arena.make_array<SegmentMoments>("segment sums", segments)),
      outside_(arena.make_array<std::uint8_t>("segments at the border", segments)),
      chosen_of_(arena.make_array<std::uint16_t>("chosen segments", segments)),
      frames_(arena.make_array<SegmentFrame>("segment frames", chosen)),
      shapes_(arena.make_array<SegmentShape>("segment shapes", chosen)),
      described_(arena.make_array<DescribedSegment>("described segments", chosen)) {}

Status SegmentDescriber::begin(const RollingGrid& grid, const Labelling& labelling) {
  if (labelling.slots().size() > std::min({moments_.size(), outside_.size(), chosen_of_.size()}))
    return Status::out_of_range;
  const bool asks = stage_ == DescribeStage::summed || stage_ == DescribeStage::described;
  if (stage_ != DescribeStage::idle && !asks) drop();
  ++counts_.begun;
  slots_ = static_cast<std::uint32_t>(labelling.slots().size());
  std::fill_n(moments_.begin(), slots_, SegmentMoments{});
  std::fill_n(outside_.begin(), slots_, std::uint8_t{0});
  std::fill_n(chosen_of_.begin(), slots_, kNone);
  labelling_ = labelling.counts().labellings;
  voxel_size_m_ = grid.config().voxel_size_m;
  anchor_ = grid.centre();
  // The sensor is somewhere in the anchor. Voxels of a block d blocks off lie up to 4 (d + sqrt 2) cells from
  // it, or 4 (d + 1) upwards; what goes on outside does so within the growing radius, at most 4 cells.
  const double inside = grid.config().radius_m / voxel_size_m_ / 4.0 - 2.4142135623730951;
  inside2_ = inside < 0.0 ? -1 : static_cast<std::int64_t>(rt::floor(inside * inside));
  inside_z_ = whole(grid.config().half_height_m / voxel_size_m_ / 4.0 - 2.0);
  stage_ = DescribeStage::summing;
  at_ = chosen_ = 0;
  return Status::ok;
}

void SegmentDescriber::drop() {
  ++counts_.dropped;
  stage_ = DescribeStage::idle;
}

std::uint32_t SegmentDescriber::run(const RollingGrid& grid, const FragmentGraph& graph,
                                    const Labelling& labelling, std::uint32_t units) {
  if (stage_ == DescribeStage::idle || stage_ == DescribeStage::described) return 0;
  if (labelling.counts().labellings != labelling_) {
    drop();
    return 0;
  }
  std::uint32_t used = 0;
  for (; stage_ == DescribeStage::framing && used < units; used += kFrameUnits) {
    DescribedSegment& segment = described_[at_];
    segment.id = labelling.id(segment.slot);
    frames_[at_] = frame_of(moments_[segment.slot], voxel_size_m_);
    if (++at_ < chosen_) continue;
    stage_ = DescribeStage::counting;
    at_ = 0;
  }
  if (stage_ != DescribeStage::summing && stage_ != DescribeStage::counting) return used;
  for (; used < units && at_ < graph.numbers(); ++at_) {
    const FragmentNode& node = graph[static_cast<NodeIndex>(at_)];
    const std::uint16_t slot = node.label[labelling.shown()];
    const bool wanted =
        node.cells != 0 && slot < slots_ && (stage_ == DescribeStage::summing || chosen_of_[slot] != kNone);
    if (wanted) visit(grid, node, slot);
    used += wanted ? bits_in(node.cells) : 1;
  }
  if (at_ >= graph.numbers()) finish();
  return used;
}

void SegmentDescriber::visit(const RollingGrid& grid, const FragmentNode& node, std::uint16_t slot) {
  const Block& block = grid.block(node.block);
  const BlockAt at = BlockAt::from_key(block.key);
  const std::int32_t off[3] = {at.x - anchor_.x, at.y - anchor_.y, at.z - anchor_.z};
  if (stage_ == DescribeStage::summing && lies_outside(at)) outside_[slot] = 1;
  // Only a map that jumped between two slices has blocks as far as that.
  if (std::max({std::abs(off[0]), std::abs(off[1]), std::abs(off[2])}) > kReach) return;
  SegmentMoments* const moments = stage_ == DescribeStage::summing ? &moments_[slot] : nullptr;
  const std::uint16_t chosen = chosen_of_[slot];
  for (std::uint64_t rest = node.cells; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    const Centroid& c = grid.voxel(block, cell);
    const std::int32_t voxel[3] = {
        kStepsOfBlock * off[0] + static_cast<std::int32_t>((cell & 3) << 8 | c.x >> 8),
        kStepsOfBlock * off[1] + static_cast<std::int32_t>((cell >> 2 & 3) << 8 | c.y >> 8),
        kStepsOfBlock * off[2] + static_cast<std::int32_t>((cell >> 4) << 8 | c.z >> 8)};
    if (moments != nullptr) {
      moments->add(voxel);
    } else {
      shapes_[chosen].add(frames_[chosen], voxel);
    }
  }
}

bool SegmentDescriber::lies_outside(const BlockAt& at) const {
  const std::int64_t dx = at.x - anchor_.x;
  const std::int64_t dy = at.y - anchor_.y;
  return dx * dx + dy * dy > inside2_ || std::abs(at.z - anchor_.z) > inside_z_;
}

Status SegmentDescriber::choose(std::span<const std::uint16_t> slots) {
  if (stage_ != DescribeStage::summed && stage_ != DescribeStage::described) return Status::empty;
  if (slots.size() > std::min({frames_.size(), shapes_.size(), described_.size()})) return Status::full;
  std::fill_n(chosen_of_.begin(), slots_, kNone);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (slots[i] < slots_ && chosen_of_[slots[i]] == kNone) {
      chosen_of_[slots[i]] = static_cast<std::uint16_t>(i);
      continue;
    }
    return Status::out_of_range;
  }
  chosen_ = static_cast<std::uint32_t>(slots.size());
  for (std::uint32_t i = 0; i < chosen_; ++i) {
    shapes_[i] = {};
    described_[i] = {};
    described_[i].slot = slots[i];
  }
  stage_ = chosen_ > 0 ? DescribeStage::framing : DescribeStage::described;
  at_ = 0;
  return Status::ok;
}

void SegmentDescriber::finish() {
  at_ = 0;
  if (stage_ == DescribeStage::summing) {
    stage_ = DescribeStage::summed;
    return;
  }
  for (std::uint32_t i = 0; i < chosen_; ++i) {
    DescribedSegment& segment = described_[i];
    const std::int64_t voxels = moments_[segment.slot].count;
    segment.voxels = static_cast<std::uint32_t>(voxels);
    segment.sound = voxels > 0 && shapes_[i].count == voxels;
    ++(segment.sound ? counts_.described : counts_.disturbed);
    if (!segment.sound) continue;
    segment.place = place(segment.slot);
    segment.descriptor = descriptor_of(frames_[i], shapes_[i]);
  }
  stage_ = DescribeStage::described;
}

PlaceCm SegmentDescriber::place(std::uint16_t slot) const {
  const SegmentMoments& m = moments_[slot];
  if (m.count <= 0) return {};
  const std::int32_t corner[3] = {anchor_.x, anchor_.y, anchor_.z};
  const double cm_of_step = 100.0 * voxel_size_m_ / kStepsOfCell;
  std::int32_t cm[3];
  for (int i = 0; i < 3; ++i) {
    // Summed up before it is divided: what is rounded does not know the anchor. Offsets were cut down, hence
    // half a step.
    const std::int64_t sum = m.sum[i] + m.count * kStepsOfBlock * corner[i];
    cm[i] = whole(cm_of_step * (static_cast<double>(sum) / static_cast<double>(m.count) + 0.5) + 0.5);
  }
  return {cm[0], cm[1], cm[2]};
}

void SegmentDescriber::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "segment describer")
      .state(counts_)
      .fixed(moments_, outside_, chosen_of_, frames_, shapes_, described_)
      .scratch(stage_, at_, slots_, chosen_, labelling_, voxel_size_m_, anchor_, inside2_, inside_z_);
  if (archive.is_reading()) stage_ = DescribeStage::idle;
}

}  // namespace sortie::mapping
