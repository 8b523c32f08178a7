// SPDX-License-Identifier: BSD-3-Clause
// What a search among images comes to.
#pragma once

#include <cstdint>

#include "mapping/recognition/image_laid.hpp"
#include "mapping/recognition/image_store.hpp"
#include "mapping/recognition/level_fit.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// Settings of a search among images.
struct ImageSearchConfig {
  static constexpr std::uint32_t kMostTurns = 256;

  std::uint32_t turns{96};                  ///< of all images together, at which all shifts are tried
  std::uint32_t most_units{2'000'000'000};  ///< of one search; what is not known then is undecided
  std::uint32_t least_cells{100};           ///< with structure
  double least_known{0.5};
  double least_share{0.97};
  double of_rival{0.85};
  double flat{0.05};
  double least_own{0.96};
  double least_kept{0.85};

  SORTIE_KEYS(c, key) {
    key("turns", c.turns, {1, kMostTurns, "turns", "of all images together, at which all shifts are tried"});
    key("most_units", c.most_units, {10'000, 4e9, "units", "of one search, of some 0.5 ns each"});
    key("least_cells", c.least_cells, {1, 1'000, "cells", "of 0.2 m with structure, to go by"});
    key("least_known", c.least_known,
        {0, 1, "", "of the structure, that must lie where the other image shows anything"});
    key("least_share", c.least_share, {0, 1, "", "of that, that must agree"});
    key("of_rival", c.of_rival, {0, 1, "", "most that another place may score, of the best one's"});
    key("flat", c.flat, {0, 1, "", "of what agrees, that must be lost 0.6 m beside the place, everywhere"});
    key("least_own", c.least_own,
        {0, 1, "", "of the structure that must agree, of all that lies near anything seen"});
    key("least_kept", c.least_kept, {0, 1, "", "the same of the kept image's structure, on the local one"});
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
  CellsLaid own;     ///< structure of the local image on the kept one
  CellsLaid kept;    ///< of the kept one on the local image
  PlaceCm middle;    ///< of the local image, in the store's map
  Heading heading;   ///< of its axes there
  LevelPlace place;  ///< T_known_local
};

/// Where the local image lies in the store's map, if it lies so on one of its images. The cost of some tens
/// of operations; what agrees is not counted.
ImageHypothesis hypothesis_of(const ImageStore& store, const ImageTurns& turns, const PlaceCm& middle,
                              std::uint32_t image, const ImagePlace& place);
/// Within a metre and ten degrees of each other in the map.
bool is_same(const ImageHypothesis& a, const ImageHypothesis& b);

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
