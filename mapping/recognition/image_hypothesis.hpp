// SPDX-License-Identifier: BSD-3-Clause
// What a search among images comes to.
#pragma once

#include <cstdint>

#include "mapping/recognition/image_view.hpp"
#include "mapping/recognition/level_fit.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// Settings of a search among images.
struct ImageSearchConfig {
  static constexpr std::uint32_t kMostCandidates = 32;
  static constexpr std::uint32_t kMostTurns = 64;

  std::uint32_t candidates{12};           ///< images that are compared, at most kMostCandidates
  std::uint32_t turns{16};                ///< of all of them together, at which all shifts are tried
  std::uint32_t most_units{200'000'000};  ///< of one search; what is not known then is undecided
  std::uint32_t least_cells{100};         ///< with structure
  double least_known{0.5};
  double least_share{0.85};
  double of_rival{0.85};
  double flat{0.05};

  SORTIE_KEYS(c, key) {
    key("candidates", c.candidates, {1, kMostCandidates, "images", "that an image is compared with"});
    key("turns", c.turns, {1, kMostTurns, "turns", "of all of them together, at which all shifts are tried"});
    key("most_units", c.most_units, {10'000, 4e9, "units", "of one search, of some 0.5 ns each"});
    key("least_cells", c.least_cells, {1, 1'000, "cells", "of 0.2 m with structure, to go by"});
    key("least_known", c.least_known,
        {0, 1, "", "of the structure, that must lie where the other image shows anything"});
    key("least_share", c.least_share, {0, 1, "", "of that, that must agree"});
    key("of_rival", c.of_rival, {0, 1, "", "most that another place may agree, of the best one's"});
    key("flat", c.flat, {0, 1, "", "of what agrees, that must be lost 0.6 m beside the place, everywhere"});
  }
};

/// What a search came to.
enum class ImageVerdict : std::uint8_t {
  none,       ///< nothing was searched, or the search goes on
  found,      ///< one place, and no other one comes near it
  few,        ///< too little structure to go by, or no images
  unlike,     ///< no image looks like it
  narrow,     ///< a place that can be moved in some direction: a corridor without anything
  ambiguous,  ///< another place looks nearly as much like it
  undecided   ///< the units were spent before that was known
};

/// A place of the local map in the store's.
struct ImageHypothesis {
  std::uint32_t image{};  ///< of the store, that it was compared with
  ImagePlace on_image;
  ImageScore score;
  PlaceCm middle;    ///< of the local image, in the store's map
  Heading heading;   ///< of its axes there
  LevelPlace place;  ///< T_known_local
};

/// Counters of searches since start.
struct ImageSearchCounts {
  std::uint64_t begun{};
  std::uint64_t found{};
  std::uint64_t few{};
  std::uint64_t unlike{};
  std::uint64_t narrow{};
  std::uint64_t ambiguous{};
  std::uint64_t undecided{};
  SORTIE_FIELDS(begun, found, few, unlike, narrow, ambiguous, undecided)
};

}  // namespace sortie::mapping
