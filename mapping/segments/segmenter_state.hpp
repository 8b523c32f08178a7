// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's state to bytes and back: with the edges that it knows, and what waits. Included by
// mapping/segments/segmenter.hpp only.
#pragma once

#include "mapping/segments/segmenter_engine.hpp"

namespace sortie::mapping {

template <SegmentationPolicy Policy>
void Segmenter<Policy>::archive(rt::Archive& archive, const RollingGrid& grid) {
  rt::Members(archive, *this, "segmenter")
      .fixed(config_, policy_, reach_, queue_, work_, status_)
      .by_hand(graph_, labelling_, queue_size_, left_of_cycle_, changed_, drained_, sweep_left_, wanting_)
      .scratch(queue_first_, read_)
      .state(cycle_, swept_);
  if (status_ != Status::ok) return;
  const bool reading = archive.is_reading();
  read_ = read_ || reading;
  const std::uint32_t blocks = grid.block_numbers();
  // A labelling that is under way begins anew before anything else happens.
  bool changed = changed_ || labelling_.running();
  bool drained = drained_ || labelling_.running();
  archive.value(changed);
  archive.value(drained);
  if (!reading) labelling_.finish_names(graph_);
  labelling_.archive(archive);
  graph_.archive(archive, grid.blocks().first(blocks), labelling_.shown(),
                 static_cast<std::uint32_t>(labelling_.slots().size()));
  archive.bounded(queue_size_, blocks);
  archive.bounded(left_of_cycle_, queue_size_);
  archive.bounded(sweep_left_, blocks);
  if (reading) {
    changed_ = changed;
    drained_ = drained;
    queue_first_ = wanting_ = 0;
    for (BlockWork& work : work_) work = {};
  }
  archive_work(archive, grid, blocks);
  archive_queue(archive, blocks);
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::archive_work(rt::Archive& archive, const RollingGrid& grid, std::uint32_t blocks) {
  const bool reading = archive.is_reading();
  for (BlockWork& work : work_.first(blocks)) {
    archive.value(work.moved);
    archive.value(work.looked);
    archive.value(work.cycle);
    archive.value(work.slack);
    archive.bounded(work.mixed, BlockWork::kAllMixed);
    bool renewed = work.renewed != 0;
    archive.value(renewed);
    work.renewed = renewed ? 1 : 0;
    bool wanting = work.wanting != 0;
    archive.value(wanting);
    if (!reading || !wanting) continue;
    const auto block = static_cast<BlockIndex>(&work - work_.data());
    if (grid.block(block).in_use()) {
      want(block);
    } else {
      archive.fail(Status::malformed, "a block that is not there wants room");
    }
  }
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::archive_queue(rt::Archive& archive, std::uint32_t blocks) {
  const bool reading = archive.is_reading();
  for (std::uint32_t i = 0; i < queue_size_; ++i) {
    BlockIndex& block = queue_[(queue_first_ + i) % queue_.size()];
    archive.value(block);
    std::uint8_t queued = reading ? 0 : work_[block].queued;
    archive.value(queued);
    if (!reading) continue;
    if (block >= blocks || work_[block].queued != 0 || queued == 0 || queued > 2) {
      archive.fail(Status::malformed, "a queue of blocks that is none");
      queue_size_ = i;
      left_of_cycle_ = 0;
      return;
    }
    work_[block].queued = queued & 3;
  }
}

}  // namespace sortie::mapping
