// SPDX-License-Identifier: BSD-3-Clause
// What each part of the descriptor tells, and what moves it.
#pragma once

#include "tests/bench/recognition/hall_pairs.hpp"

namespace sortie::bench {

/// Rows of a table, for each part of the 24 bytes and for all of them: the area under the curve of its steps
/// alone, and their mean difference between the same segments of two visits, between the same segments of
/// the same scans in a map that is turned by 45 degrees, and between different segments.
Json part_rows(const std::vector<HallPairs>& halls, const std::string& policy);

inline const std::vector<std::string> kPartColumns{
    "segments", "part", "bytes", "area", "same, other visit", "same scans, map turned", "different"};

}  // namespace sortie::bench
