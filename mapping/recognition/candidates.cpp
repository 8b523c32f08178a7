// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/candidates.hpp"

#include <algorithm>
#include <bit>

namespace sortie::mapping {

CandidateSearch::CandidateSearch(const CandidateConfig& config) : config_(config) {
  config_.most = std::clamp(config.most, 1u, CandidateConfig::kMost);
}

void CandidateSearch::begin(const CandidateQuery& query) {
  query_ = query;
  found_ = compared_ = at_ = 0;
  credit_.clear();
}

bool CandidateSearch::run(const TargetStore& store, std::uint64_t& units) {
  const auto size = static_cast<std::uint32_t>(store.records().size());
  while (at_ < size) {
    if (!credit_.pay(kUnitsADescriptor * TargetSizes::kBlock, units)) return false;
    look(store, at_);
    at_ += TargetSizes::kBlock;
  }
  return true;
}

bool CandidateSearch::is_wanted(const TargetRecord& record, const PlaceCm& place) const {
  if (query_.leaves_out && record.robot == query_.robot &&
      record.last_seen_ms - query_.since_ms < std::uint32_t{1} << 31)
    return false;
  if (!query_.has_prior) return true;
  const std::int64_t radius = query_.radius_cm;
  const std::int64_t apart[] = {std::int64_t{place.x} - query_.prior.x,
                                std::int64_t{place.y} - query_.prior.y,
                                std::int64_t{place.z} - query_.prior.z};
  std::uint64_t square = 0;  // three of 2^62 at most
  for (const std::int64_t d : apart) {
    if (d > radius || d < -radius) return false;
    square += static_cast<std::uint64_t>(d * d);
  }
  return square <= static_cast<std::uint64_t>(radius * radius);
}

void CandidateSearch::look(const TargetStore& store, std::uint32_t first) {
  const bool is_narrow = query_.has_prior || query_.leaves_out;
  const TargetRecord* const records = store.records().data();
  const PlaceCm* const places = store.places().data();
  std::uint64_t rest = store.sizes().passing(first, query_.descriptor, config_.size_steps);
  for (; rest != 0; rest &= rest - 1) {
    const std::uint32_t target = first + static_cast<std::uint32_t>(std::countr_zero(rest));
    const TargetRecord& record = records[target];
    if (is_narrow && !is_wanted(record, places[target])) continue;
    ++compared_;
    const std::uint64_t distance = difference(query_.descriptor, record.descriptor);
    insert(distance << 24 | std::uint64_t{255u - record.uniqueness} << 16 | target);
  }
}

void CandidateSearch::insert(std::uint64_t rank) {
  if (found_ == config_.most && rank >= ranks_[found_ - 1]) return;
  std::uint32_t at = found_ < config_.most ? found_++ : found_ - 1;
  for (; at > 0 && rank < ranks_[at - 1]; --at) ranks_[at] = ranks_[at - 1];
  ranks_[at] = rank;
}

Candidate CandidateSearch::operator[](std::uint32_t i) const {
  const std::uint64_t rank = ranks_[i];
  return {static_cast<TargetIndex>(rank), static_cast<std::uint16_t>(rank >> 24),
          static_cast<std::uint8_t>(255 - (rank >> 16 & 255))};
}

}  // namespace sortie::mapping
