// SPDX-License-Identifier: BSD-3-Clause
// Settings of the search of a place on a kept map.
#pragma once

#include <cstdint>

#include "rt/keys.hpp"

namespace sortie::mapping {

/// The coarse search.
struct PlaceSearchConfig {
  static constexpr std::uint32_t kLeastReturns = 48;  ///< with fewer nothing is searched
  static constexpr std::uint32_t kMostReturns = 124;
  static constexpr std::uint32_t kMostCandidates = 96;
  std::uint32_t returns{124};
  std::uint32_t candidates{48};
  std::uint32_t rivals{12};
  double rivals_within{0.35};
  double reach_m{20.0};
  double least_hits{0.5};
  double within{0.08};
  std::uint32_t tops{1024};

  SORTIE_KEYS(c, key) {
    key("returns", c.returns, {kLeastReturns, kMostReturns, "returns", "of a scan that are searched with"});
    key("candidates", c.candidates, {2, 64, "places", "well apart, that are then matched"});
    key("reach_m", c.reach_m, {2, 60, "m", "farther returns are not searched with"});
    key("least_hits", c.least_hits,
        {0.1, 1, "", "of the returns, that must lie near surfaces at a candidate"});
    key("rivals", c.rivals,
        {0, 32, "places", "more, along the best one's turn and a quarter and half a turn from it"});
    key("rivals_within", c.rivals_within, {0.01, 1, "", "these may have that part fewer hits than the best"});
    key("limits.tops", c.tops,
        {1, 65'536, "", "blocks of 8 cells along each axis that a map may have; 16 kB each"});
    key("within", c.within, {0.01, 1, "", "candidates may have that part fewer hits than the best"});
  }
};

/// What a place needs to be believed.
struct RelocateConfig {
  std::uint32_t first_returns{256};   ///< that all candidates are first matched with
  std::uint32_t tried_returns{1024};  ///< that the best ones are then matched with
  double least_share{0.75};
  double least_seen{0.6};
  double most_crossed{0.1};
  double least_lead{0.06};
  double of_gaps{0.5};
  double over_rival{2.0};
  double over_unexplained{1.0};
  double surely_over_unexplained{3.0};

  SORTIE_KEYS(c, key) {
    key("first_returns", c.first_returns,
        {64, 8192, "returns", "that all candidates are first matched with"});
    key("tried_returns", c.tried_returns, {128, 8192, "returns", "that the best 32 are then matched with"});
    key("least_share", c.least_share,
        {0, 1, "", "of the returns where the map has seen something, that must lie on a surface"});
    key("least_seen", c.least_seen,
        {0, 1, "", "of the returns, that must lie where the map has seen something"});
    key("most_crossed", c.most_crossed, {0, 1, "", "of the rays that may go through surfaces"});
    key("least_lead", c.least_lead,
        {0, 1, "", "of the scan, that more must speak for a place than for each other one"});
    key("over_unexplained", c.over_unexplained,
        {0, 100, "", "times what the place leaves unexplained, that must speak for it beside that"});
    key("surely_over_unexplained", c.surely_over_unexplained,
        {0, 100, "", "the same, of a place that a second look nearby may confirm (second_look_m)"});
    key("of_gaps", c.of_gaps,
        {0, 1, "", "of what a place explains where another one has a gap in the map: speaks for it"});
    key("over_rival", c.over_rival, {1, 100, "", "times as much must speak for it as for another one"});
  }
};

}  // namespace sortie::mapping
