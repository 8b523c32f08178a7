// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/segment_report.hpp"

#include <cmath>

namespace sortie::firmware {
namespace {

std::uint8_t listed_change(mapping::SegmentChange change) {
  return change == mapping::SegmentChange::born      ? rt::ListedEvent::kBorn
         : change == mapping::SegmentChange::renamed ? rt::ListedEvent::kRenamed
                                                     : rt::ListedEvent::kGone;
}

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
      queue_(&queue) {
  list_.features = features;
}

void SegmentReport::note(const ChosenMap& map) {
  const mapping::Labelling* segments = map.labelling();
  if (segments == nullptr || segments->counts().labellings == labellings_) return;
  labellings_ = segments->counts().labellings;
  fresh_ = true;
  for (const mapping::SegmentEvent& event : segments->events()) {
    ++list_.events;
    if (list_.listed_events == rt::SegmentList::kMostEvents) continue;
    list_.event[list_.listed_events++] = {listed_change(event.change), event.id, event.other};
  }
}

void SegmentReport::send(const ChosenMap& map, rt::Nanoseconds stamp_ns) {
  if (!fresh_) return;
  fresh_ = false;
  const mapping::Labelling& segments = *map.labelling();
  list_.stamp_ns = stamp_ns;
  list_.segments = list_.listed = 0;
  const std::span<const mapping::SegmentSlot> slots = segments.slots();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::uint32_t voxels = slots[i].voxels[segments.shown()];
    if (slots[i].id == mapping::kNoSegment || voxels == 0) continue;
    ++list_.segments;
    if (list_.listed == rt::SegmentList::kMost) continue;
    slot_of_[list_.listed] = static_cast<std::uint16_t>(i);
    rt::ListedSegment& segment = list_.segment[list_.listed++];
    segment = {};
    segment.id = slots[i].id;
    segment.voxels = voxels;
  }
  if (list_.features) add_features(map);
  // What a full queue did not take, the next list tells.
  if (queue_->put(list_)) list_.events = list_.listed_events = 0;
}

void SegmentReport::add_features(const ChosenMap& map) {
  const mapping::RollingGrid& grid = map.grid();
  const double edge_m = grid.config().voxel_size_m;
  if (!mapping::sum_segments(grid, *map.graph(), *map.labelling(), moments_)) return;
  const mapping::BlockAt& anchor = grid.centre();
  const rt::Vector3 origin =
      grid.to_world(4.0 * edge_m * rt::Vector3{1.0 * anchor.x, 1.0 * anchor.y, 1.0 * anchor.z});
  rt::store(origin, list_.origin_m);
  const rt::RotationMatrix turn = to_matrix(grid.world_from_grid().q);
  for (std::uint32_t i = 0; i < list_.listed; ++i) {
    rt::ListedSegment& segment = list_.segment[i];
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
