// SPDX-License-Identifier: BSD-3-Clause
// What it takes to find the candidates of a local map's segments in a store of targets.
#pragma once

#include "tests/bench/recognition/hall_pairs.hpp"

namespace sortie::bench {

/// Time of a search for the 16 nearest of `targets` targets, for 64 segments, one round a sample.
struct RetrievalTimes {
  Rounds ours_ms;       ///< the store's search: gate, then 24 bytes
  Rounds features_ms;   ///< seven features, all targets, the 16 nearest kept
  double compared{};    ///< share of the targets that the gate lets through
  std::size_t wrong{};  ///< searches whose list is not the one that a look at all targets gives
};

/// Targets are the first visits' segments of all halls, over and over; asked for are the second visits'.
RetrievalTimes time_retrieval(const std::vector<HallPairs>& halls, std::size_t targets, int rounds);

}  // namespace sortie::bench
