// SPDX-License-Identifier: BSD-3-Clause
// Learns the decision trees of estimators/obstacle_tree_table.hpp from drives of the plant.
#pragma once

#include <cstdint>
#include <vector>

namespace sortie::bench {

/// Drives the scenes of these seeds and prints the table as C++ to stdout. A few minutes and some GB.
void train_modes(const std::vector<std::uint64_t>& seeds);

}  // namespace sortie::bench
