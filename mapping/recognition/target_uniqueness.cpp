// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/target_uniqueness.hpp"

#include <algorithm>
#include <bit>

#include "mapping/recognition/segment_descriptor.hpp"

namespace sortie::mapping {

TargetUniqueness::TargetUniqueness(std::int32_t apart_cm, std::uint32_t targets, rt::Arena& arena)
    : apart2_(std::int64_t{apart_cm} * apart_cm) {
  const std::size_t words = (std::size_t{targets} + 63) / 64;
  const auto all = arena.make_array<std::uint64_t>("targets_changed", 2 * words);
  if (all.empty()) return;
  changed_ = all.first(words);
  asks_ = all.subspan(words);
}

void TargetUniqueness::clear() {
  std::fill(changed_.begin(), changed_.end(), 0);
  std::fill(asks_.begin(), asks_.end(), 0);
  waiting_ = at_ = target_ = least_ = 0;
  nearest_ = kNoTarget;
  under_way_ = renews_others_ = false;
  passes_ = 0;
  credit_.clear();
}

void TargetUniqueness::changed(TargetIndex target) {
  if (!waits(target)) ++waiting_;
  changed_[target / 64] |= std::uint64_t{1} << (target % 64);
  if (under_way_ && target_ == target) under_way_ = false;  // begins anew
}

void TargetUniqueness::ask(std::uint32_t target) {
  if (waits(target)) return;
  ++waiting_;
  asks_[target / 64] |= std::uint64_t{1} << (target % 64);
}

/// The next that waits, from where the last one was, round.
void TargetUniqueness::begin() {
  const auto words = static_cast<std::uint32_t>(changed_.size());
  std::uint32_t word = target_ / 64;
  std::uint64_t there = (changed_[word] | asks_[word]) & (~std::uint64_t{0} << (target_ % 64));
  while (there == 0) {
    word = word + 1 == words ? 0 : word + 1;
    there = changed_[word] | asks_[word];
  }
  target_ = static_cast<std::uint16_t>(64 * word + static_cast<std::uint32_t>(std::countr_zero(there)));
  renews_others_ = has(changed_, target_);
  under_way_ = true;
  at_ = 0;
  least_ = TargetRecord::kMostUnique;
  nearest_ = kNoTarget;
}

bool TargetUniqueness::run(std::span<TargetRecord> records, std::span<const PlaceCm> places,
                           std::uint64_t& units) {
  const auto size = static_cast<std::uint32_t>(records.size());
  while (waiting_ > 0) {
    if (!under_way_) begin();
    const std::uint32_t end = std::min(at_ + kBlock, size);
    if (!credit_.pay(2 * kBlock, units)) return false;
    compare(records, places, end);
    // Nothing is nearer than the first at distance 0.
    if (at_ == size || (least_ == 0 && !renews_others_)) finish(records);
  }
  return true;
}

void TargetUniqueness::compare(std::span<TargetRecord> records, std::span<const PlaceCm> places,
                               std::uint32_t end) {
  const TargetRecord own = records[target_];
  const PlaceCm place = places[target_];
  for (; at_ < end; ++at_) {
    TargetRecord& other = records[at_];
    if (at_ == target_ || other.state == TargetState::free) continue;
    std::uint32_t distance = TargetRecord::kMostUnique;
    if (own.state != TargetState::free && square_apart(place, places[at_]) > apart2_)
      distance = std::min<std::uint32_t>(distance, difference(own.descriptor, other.descriptor));
    if (distance < least_) {
      least_ = static_cast<std::uint16_t>(distance);
      nearest_ = static_cast<TargetIndex>(at_);
    }
    // Whoever waits will see this one in a pass of its own.
    if (!renews_others_ || waits(at_)) continue;
    const bool is_nearer =
        distance < other.uniqueness || (distance == other.uniqueness && target_ < other.nearest);
    if (distance < TargetRecord::kMostUnique && is_nearer) {
      other.uniqueness = static_cast<std::uint8_t>(distance);
      other.nearest = target_;
    } else if (other.nearest == target_ && distance != other.uniqueness) {
      ask(at_);
    }
  }
}

void TargetUniqueness::finish(std::span<TargetRecord> records) {
  TargetRecord& own = records[target_];
  if (own.state != TargetState::free) {
    own.uniqueness = static_cast<std::uint8_t>(least_);
    own.nearest = nearest_;
  }
  const std::uint64_t bit = std::uint64_t{1} << (target_ % 64);
  changed_[target_ / 64] &= ~bit;
  asks_[target_ / 64] &= ~bit;
  --waiting_;
  under_way_ = false;
  ++passes_;
}

void TargetUniqueness::archive(rt::Archive& archive, std::span<const TargetRecord> records) {
  rt::Members(archive, *this, "uniqueness of targets")
      .fixed(apart2_)
      .by_hand(changed_, asks_, waiting_)
      .state(at_, target_, least_, nearest_, under_way_, renews_others_, passes_, credit_);
  for (std::size_t word = 0; word < changed_.size(); ++word) {
    archive.value(changed_[word]);
    archive.value(asks_[word]);
  }
  if (!archive.is_reading() || archive.status() != Status::ok) return;
  const auto size = static_cast<std::uint32_t>(records.size());
  waiting_ = 0;
  bool fits = at_ <= size && least_ <= TargetRecord::kMostUnique &&
              (size == 0 ? target_ == 0 : target_ < size) && (nearest_ < size || nearest_ == kNoTarget);
  for (std::uint32_t target = 0; target < 64 * changed_.size(); ++target) {
    if (!waits(target)) continue;
    ++waiting_;
    fits = fits && target < size;
  }
  fits = fits && (!under_way_ || waits(target_));
  if (!fits) archive.fail(Status::malformed, "a comparison of targets that cannot be");
}

}  // namespace sortie::mapping
