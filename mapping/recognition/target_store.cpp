// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/target_store.hpp"

#include <algorithm>

#include "mapping/recognition/segment_descriptor.hpp"

namespace sortie::mapping {

TargetStore::TargetStore(const TargetStoreConfig& config, rt::Arena& arena)
    : config_(config),
      records_(arena.make_array<TargetRecord>(
          "targets", std::min(config.targets, TargetStoreConfig::kMostTargets), rt::kCacheLineBytes)),
      sizes_(capacity(), arena),
      places_(std::min(config.key_frames, TargetStoreConfig::kMostKeyFrames), capacity(), arena),
      uniqueness_(config.apart_cm, capacity(), arena) {
  if (arena.refused() > 0) records_ = {};
}

void TargetStore::clear() {
  std::fill(records_.begin(), records_.end(), TargetRecord{});
  sizes_.clear();
  places_.clear();
  uniqueness_.clear();
  used_ = kept_ = 0;
  counts_ = {};
}

/// The record that a sighting is of, by its id or else by its place and look.
TargetIndex TargetStore::same_as(const TargetSighting& sighting, const PlaceCm& place, bool& by_id) const {
  TargetIndex same = kNoTarget;
  std::int64_t least = std::int64_t{config_.same_cm} * config_.same_cm;
  by_id = false;
  for (std::uint32_t i = 0; i < used_; ++i) {
    const TargetRecord& one = records_[i];
    if (one.state == TargetState::free || one.robot != sighting.robot) continue;
    if (one.id == sighting.id) {
      by_id = true;
      return static_cast<TargetIndex>(i);
    }
    if (difference(one.descriptor, sighting.descriptor) > config_.same_steps) continue;
    const std::int64_t apart = square_apart(latest_place(one), place);
    if (apart >= least) continue;
    least = apart;
    same = static_cast<TargetIndex>(i);
  }
  return same;
}

TargetIndex TargetStore::lowest_free() const {
  if (kept_ == used_) return static_cast<TargetIndex>(used_);
  std::uint32_t at = 0;
  while (records_[at].state != TargetState::free) ++at;
  return static_cast<TargetIndex>(at);
}

/// A record that was written: all that follows from it.
void TargetStore::keep(TargetIndex target) {
  TargetRecord& record = records_[target];
  if (record.state == TargetState::free) ++kept_;
  record.state = TargetState::kept;
  used_ = std::max<std::uint32_t>(used_, target + 1u);
  ++record.edition;
  sizes_.put(target, record);
  places_.place(target, record);
  uniqueness_.changed(target);
}

TargetStore::Put TargetStore::put(const TargetSighting& sighting) {
  if (!places_.knows(sighting.key_frame) || !is_usable_offset(sighting.offset)) {
    ++counts_.refused;
    return {Status::out_of_range, kNoTarget, false};
  }
  const PlaceCm place = place_of(places_.latest(sighting.key_frame), sighting.offset);
  bool by_id = false;
  TargetIndex target = same_as(sighting, place, by_id);
  const bool added = target == kNoTarget;
  if (!added) {
    ++(by_id ? counts_.renewed : counts_.adopted);
  } else if (kept_ < capacity()) {
    target = lowest_free();
  } else if (capacity() > 0) {
    target = evicted_for(place, sighting.stamp_ms);
    ++counts_.evicted;
  } else {
    ++counts_.refused;
    return {Status::full, kNoTarget, false};
  }
  TargetRecord& record = records_[target];
  if (added) {
    ++counts_.added;
    record.views = 0;
    record.uniqueness = 0;
    record.nearest = kNoTarget;
  }
  record.descriptor = sighting.descriptor;
  record.id = sighting.id;
  record.voxels = sighting.voxels;
  record.last_seen_ms = sighting.stamp_ms;
  record.offset = sighting.offset;
  record.key_frame = sighting.key_frame;
  record.version = sighting.version;
  record.robot = sighting.robot;
  if (record.views < 0xffff) ++record.views;
  keep(target);
  return {Status::ok, target, added};
}

bool TargetStore::is_usable(const TargetRecord& record) const {
  return places_.knows(record.key_frame) && is_usable_offset(record.offset) && record.views > 0;
}

Status TargetStore::take(const TargetRecord& record) {
  if (!is_usable(record)) {
    ++counts_.refused;
    return Status::out_of_range;
  }
  if (kept_ == capacity()) {
    ++counts_.refused;
    return Status::full;
  }
  const TargetIndex target = lowest_free();
  const std::uint32_t edition = records_[target].edition;
  records_[target] = record;
  records_[target].edition = edition;
  records_[target].nearest = kNoTarget;
  records_[target].state = TargetState::free;
  ++counts_.added;
  keep(target);
  return Status::ok;
}

bool TargetStore::remove(TargetIndex target) {
  if (target >= used_ || records_[target].state == TargetState::free) return false;
  const std::uint32_t edition = records_[target].edition;
  records_[target] = {};
  records_[target].edition = edition + 1;
  sizes_.put(target, records_[target]);
  uniqueness_.changed(target);
  --kept_;
  ++counts_.removed;
  return true;
}

TargetIndex TargetStore::find(std::uint8_t robot, std::uint32_t id) const {
  for (std::uint32_t i = 0; i < used_; ++i) {
    const TargetRecord& one = records_[i];
    if (one.id == id && one.robot == robot && one.state != TargetState::free)
      return static_cast<TargetIndex>(i);
  }
  return kNoTarget;
}

bool TargetStore::run(std::uint64_t& units) {
  const auto moved = [this](TargetIndex target) { uniqueness_.changed(target); };
  return places_.run(records(), units, moved) && uniqueness_.run(records_.first(used_), places(), units);
}

void TargetStore::archive(rt::Archive& archive) {
  archive.expect(capacity(), "another number of targets than this store's");
  if (archive.is_reading()) clear();
  {
    rt::Members members(archive, *this, "store of targets");
    members.fixed(config_)
        .by_hand(records_, places_, uniqueness_, used_, kept_)
        .scratch(sizes_)
        .state(counts_);
    archive.bounded(used_, capacity());
    kept_ = 0;
    bool fits = true;
    for (std::uint32_t i = 0; i < used_ && archive.status() == Status::ok; ++i) {
      TargetRecord& one = records_[i];
      archive.value(one);
      if (one.state != TargetState::free) ++kept_;
      fits = fits && one.state <= TargetState::kept && (one.nearest < used_ || one.nearest == kNoTarget) &&
             (one.state == TargetState::free || (is_usable_offset(one.offset) && one.views > 0));
    }
    if (!fits) archive.fail(Status::malformed, "a target that cannot be");
    places_.archive(archive, records());
    uniqueness_.archive(archive, records());
  }
  if (!archive.is_reading()) return;
  if (archive.status() != Status::ok) return clear();
  for (std::uint32_t i = 0; i < used_; ++i) sizes_.put(static_cast<TargetIndex>(i), records_[i]);
}

}  // namespace sortie::mapping
