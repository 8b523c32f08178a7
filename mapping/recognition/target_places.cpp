// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/target_places.hpp"

#include <algorithm>

namespace sortie::mapping {

TargetPlaces::TargetPlaces(std::uint32_t key_frames, std::uint32_t targets, rt::Arena& arena) {
  const auto poses = arena.make_array<KeyFramePose>("target_key_frames", std::size_t{key_frames} * 3);
  const auto places = arena.make_array<PlaceCm>("target_places", std::size_t{targets} * 2);
  known_ = arena.make_array<bool>("target_key_frames", key_frames);
  if (poses.empty() || (places.empty() && targets > 0)) {
    known_ = {};  // no room: it takes no key frame
    return;
  }
  latest_ = poses.first(key_frames);
  for (std::size_t i = 0; i < 2; ++i) {
    tables_[i].poses = poses.subspan((i + 1) * key_frames, key_frames);
    tables_[i].places = places.subspan(i * targets, targets);
  }
}

void TargetPlaces::clear() {
  std::fill(known_.begin(), known_.end(), false);
  at_ = tables_shown_ = shown_ = 0;
  building_ = moved_ = false;
  credit_.clear();
}

Status TargetPlaces::set(std::uint16_t key_frame, const KeyFramePose& pose) {
  if (key_frame >= known_.size() || !pose.usable()) return Status::out_of_range;
  if (!known_[key_frame]) {
    known_[key_frame] = true;
    for (const Table& table : tables_) table.poses[key_frame] = pose;
  } else if (latest_[key_frame] == pose) {
    return Status::ok;
  } else {
    moved_ = true;
  }
  latest_[key_frame] = pose;
  return Status::ok;
}

void TargetPlaces::place(TargetIndex target, const TargetRecord& record) {
  for (const Table& table : tables_)
    table.places[target] = place_of(table.poses[record.key_frame], record.offset);
}

void TargetPlaces::begin() {
  std::copy(latest_.begin(), latest_.end(), tables_[1 - shown_].poses.begin());
  building_ = true;
  moved_ = false;
  at_ = 0;
}

bool TargetPlaces::build(TargetIndex target, const TargetRecord& record) {
  Table& next = tables_[1 - shown_];
  next.places[target] = place_of(next.poses[record.key_frame], record.offset);
  return next.places[target] != tables_[shown_].places[target];
}

void TargetPlaces::show() {
  shown_ = static_cast<std::uint8_t>(1 - shown_);
  building_ = false;
  at_ = 0;
  ++tables_shown_;
}

void TargetPlaces::archive(rt::Archive& archive, std::span<const TargetRecord> records) {
  archive.expect(known_.size(), "another number of key frames than this table's");
  rt::Members(archive, *this, "places of targets")
      .by_hand(known_, latest_, tables_)
      .state(at_, tables_shown_, shown_, building_, moved_, credit_);
  bool fits = shown_ <= 1 && at_ <= tables_[0].places.size() && at_ % kBlock == 0;
  if (!fits) shown_ = 0;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    archive.value(known_[i]);
    if (!known_[i]) continue;
    KeyFramePose* const poses[3] = {&latest_[i], &tables_[shown_].poses[i], &tables_[1 - shown_].poses[i]};
    for (int one = 0; one < (building_ ? 3 : 2); ++one) {
      archive.value(*poses[one]);
      fits = fits && poses[one]->usable();
    }
    if (!building_) *poses[2] = *poses[1];  // of a state that was refused before it may be anything
  }
  if (!archive.is_reading() || archive.status() != Status::ok) return;
  for (const TargetRecord& record : records)
    fits = fits && (record.state == TargetState::free || knows(record.key_frame));
  if (!fits) return archive.fail(Status::malformed, "a key frame that cannot be, or is not there");
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].state != TargetState::free) place(static_cast<TargetIndex>(i), records[i]);
  }
}

}  // namespace sortie::mapping
