// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/segment_report.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::firmware {
namespace {

void put_place(float (&to)[3], const rt::Vector3& p, const rt::Vector3& origin) {
  to[0] = static_cast<float>(p.x - origin.x);
  to[1] = static_cast<float>(p.y - origin.y);
  to[2] = static_cast<float>(p.z - origin.z);
}

}  // namespace

SegmentReport::SegmentReport(const ChosenMapConfig& config, bool features,
                             ReportQueue<rt::SegmentList>& queue, rt::Arena& arena)
    : moments_(
          arena.make_array<mapping::SegmentMoments>("segment sums", features ? config.most_segments : 0)),
      queue_(&queue) {}

void SegmentReport::note(const ChosenMap& map) {
  const mapping::Labelling* segments = map.labelling();
  if (segments == nullptr || segments->counts().labellings == labellings_) return;
  labellings_ = segments->counts().labellings;
  fresh_ = true;
  for (const rt::SegmentEvent& event : segments->events()) {
    if (events_ < rt::SegmentList::kMostEvents) event_[events_] = event;
    ++events_;
  }
}

void SegmentReport::send(const ChosenMap& map, rt::Nanoseconds stamp_ns) {
  if (!fresh_) return;
  fresh_ = false;
  rt::SegmentList* const list = queue_->claim();
  if (list == nullptr) return;  // what a full queue has no room for, the next list tells
  const mapping::Labelling& segments = *map.labelling();
  list->stamp_ns = stamp_ns;
  list->segments = list->listed = 0;
  const std::span<const mapping::SegmentSlot> slots = segments.slots();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::uint32_t voxels = slots[i].voxels[segments.shown()];
    if (slots[i].id == mapping::kNoSegment || voxels == 0) continue;
    ++list->segments;
    if (list->listed == rt::SegmentList::kMost) continue;
    slot_of_[list->listed] = static_cast<std::uint16_t>(i);
    rt::ListedSegment& segment = list->segment[list->listed++];
    segment = {};
    segment.id = slots[i].id;
    segment.voxels = voxels;
  }
  list->events = events_;
  list->listed_events = std::min(events_, rt::SegmentList::kMostEvents);
  std::copy_n(event_, list->listed_events, list->event);
  events_ = 0;
  list->features = !moments_.empty();
  if (list->features) add_features(map, *list);
  queue_->publish();
}

void SegmentReport::add_features(const ChosenMap& map, rt::SegmentList& list) {
  const mapping::RollingGrid& grid = map.grid();
  const double edge_m = grid.config().voxel_size_m;
  if (!mapping::sum_segments(grid, *map.graph(), *map.labelling(), moments_)) return;
  const mapping::BlockAt& anchor = grid.centre();
  const rt::Vector3 origin =
      grid.to_world(4.0 * edge_m * rt::Vector3{1.0 * anchor.x, 1.0 * anchor.y, 1.0 * anchor.z});
  rt::store(origin, list.origin_m);
  const rt::RotationMatrix turn = to_matrix(grid.world_from_grid().q);
  for (std::uint32_t i = 0; i < list.listed; ++i) {
    rt::ListedSegment& segment = list.segment[i];
    const mapping::SegmentFeatures f = mapping::features_of(moments_[slot_of_[i]], anchor, edge_m);
    put_place(segment.centroid_m, grid.to_world(f.centroid_m), origin);
    // The box's axes are the world's: around the grid's box, should the grid have been turned.
    const rt::Vector3 middle = grid.to_world(0.5 * (f.least_m + f.most_m));
    const rt::Vector3 h = 0.5 * (f.most_m - f.least_m);
    const rt::Vector3 x = turn * rt::Vector3{h.x, 0, 0};
    const rt::Vector3 y = turn * rt::Vector3{0, h.y, 0};
    const rt::Vector3 z = turn * rt::Vector3{0, 0, h.z};
    const rt::Vector3 half{std::fabs(x.x) + std::fabs(y.x) + std::fabs(z.x),
                           std::fabs(x.y) + std::fabs(y.y) + std::fabs(z.y),
                           std::fabs(x.z) + std::fabs(y.z) + std::fabs(z.z)};
    put_place(segment.least_m, middle - half, origin);
    put_place(segment.most_m, middle + half, origin);
    const double features[] = {f.linearity,  f.planarity,    f.scattering,      f.omnivariance,
                               f.anisotropy, f.eigenentropy, f.curvature_change};
    for (std::uint32_t k = 0; k < rt::ListedSegment::kFeatures; ++k)
      segment.feature[k] = static_cast<float>(features[k]);
  }
}

}  // namespace sortie::firmware
