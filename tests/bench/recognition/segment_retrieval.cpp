// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/segment_retrieval.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>

#include "tests/bench/recognition/owned_sets.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;

constexpr std::size_t kAsked = 64;
constexpr std::int32_t kApartCm = 2000;  ///< between targets: none is taken for another one

using FeatureRow = std::array<double, SegmentLikeness::kFeatures>;

FeatureRow row_of(const SegmentFeatures& f) {
  return {f.linearity,  f.planarity,    f.scattering,      f.omnivariance,
          f.anisotropy, f.eigenentropy, f.curvature_change};
}

/// The sixteen nearest by a look at all; the squared distances' order is that of the distances.
std::size_t nearest_rows(const std::vector<FeatureRow>& targets, const FeatureRow& asked,
                         std::vector<std::pair<double, std::size_t>>& list) {
  list.clear();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    double square = 0.0;
    for (std::size_t k = 0; k < asked.size(); ++k) {
      const double apart = targets[i][k] - asked[k];
      square += apart * apart;
    }
    list.emplace_back(square, i);
  }
  const std::size_t most = std::min<std::size_t>(CandidateConfig{}.most, list.size());
  std::nth_element(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(most) - 1, list.end());
  std::sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(most));
  return list[0].second;
}

std::vector<const SpokenSegment*> repeated(const std::vector<HallPairs>& halls, int visit,
                                           std::size_t count) {
  std::vector<const SpokenSegment*> once, all;
  for (const HallPairs& hall : halls) {
    for (const SpokenSegment& segment : hall.visit[visit].segments) once.push_back(&segment);
  }
  if (once.empty()) throw std::runtime_error("descriptors: halls without segments");
  while (all.size() < count) all.push_back(once[all.size() % once.size()]);
  return all;
}

/// Whether a search found what a look at all targets finds. Before uniqueness is known the order is that of
/// distances, then of numbers.
bool is_right(const CandidateSearch& search, const TargetStore& store, const SegmentDescriptor& asked) {
  std::vector<std::pair<std::uint32_t, std::size_t>> list;
  for (std::size_t i = 0; i < store.records().size(); ++i) {
    const SegmentDescriptor& target = store.records()[i].descriptor;
    if (same_sizes(asked, target, static_cast<std::int32_t>(search.config().size_steps)))
      list.emplace_back(difference(asked, target), i);
  }
  std::sort(list.begin(), list.end());
  if (search.size() != std::min<std::size_t>(list.size(), search.config().most)) return false;
  for (std::uint32_t i = 0; i < search.size(); ++i) {
    if (search[i].target != list[i].second || search[i].distance != list[i].first) return false;
  }
  return true;
}

}  // namespace

RetrievalTimes time_retrieval(const std::vector<HallPairs>& halls, std::size_t targets, int rounds) {
  const std::vector<const SpokenSegment*> kept = repeated(halls, 0, targets),
                                          asked = repeated(halls, 1, kAsked);
  TargetStoreConfig config;
  config.targets = static_cast<std::uint32_t>(targets);
  std::vector<std::byte> memory(targets * 200 + std::size_t{config.key_frames} * 64 + 4096);
  rt::Arena arena(memory);
  TargetStore store(config, arena);
  std::vector<FeatureRow> rows;
  if (store.set_key_frame(0, {{}, {Heading::kOne, 0}}) != Status::ok)
    throw std::runtime_error("descriptors: no key frame");
  for (std::size_t i = 0; i < kept.size(); ++i) {
    TargetSighting sighting;
    sighting.id = static_cast<std::uint32_t>(i + 1);
    sighting.voxels = kept[i]->features.voxels;
    sighting.offset = {kApartCm * static_cast<std::int32_t>(i % 500),
                       kApartCm * static_cast<std::int32_t>(i / 500), 0};
    sighting.descriptor = kept[i]->descriptor;
    if (!store.put(sighting).added) throw std::runtime_error("descriptors: a target was refused");
    rows.push_back(row_of(kept[i]->features));
  }
  RetrievalTimes times;
  CandidateSearch search{CandidateConfig{}};
  std::vector<std::pair<double, std::size_t>> list;
  for (int round = 0; round < rounds; ++round) {
    std::size_t compared = 0;
    double begin = set_cpu_ms();
    for (const SpokenSegment* const segment : asked) {
      CandidateQuery query;
      query.descriptor = segment->descriptor;
      search.begin(query);
      std::uint64_t units = ~std::uint64_t{0};
      (void)search.run(store, units);
      compared += search.compared();
    }
    times.ours_ms.add(set_cpu_ms() - begin);
    times.compared = static_cast<double>(compared) / static_cast<double>(kept.size() * asked.size());
    begin = set_cpu_ms();
    volatile std::size_t kept_alive = 0;
    for (const SpokenSegment* const segment : asked)
      kept_alive = kept_alive + nearest_rows(rows, row_of(segment->features), list);
    times.features_ms.add(set_cpu_ms() - begin);
  }
  for (const SpokenSegment* const segment : asked) {
    CandidateQuery query;
    query.descriptor = segment->descriptor;
    search.begin(query);
    std::uint64_t units = ~std::uint64_t{0};
    (void)search.run(store, units);
    times.wrong += is_right(search, store, segment->descriptor) ? 0 : 1;
  }
  return times;
}

}  // namespace sortie::bench
