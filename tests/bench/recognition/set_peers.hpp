// SPDX-License-Identifier: BSD-3-Clause
// Other ways to find which correspondences agree, re-made from their papers, and PCL's.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/recognition/consistency_gate.hpp"

namespace sortie::bench {

/// Numbers of the correspondences that a method takes for right.
using Chosen = std::vector<std::uint32_t>;

/// A dense cluster of the weighted graph (P. C. Lusk, K. Fathian, J. P. How, CLIPPER, 2021): distances in
/// space that differ by less than `eps_m` score exp(-c^2 / (2 (eps_m / 4)^2)); the score of a unit vector is
/// raised by projected gradient steps while what contradicts costs more and more. Sparse, in double
/// precision.
Chosen dense_cluster(const std::vector<mapping::SweptPair>& pairs, double eps_m, std::uint64_t seed);

/// Vertices of the largest core number (J. Shi, H. Yang, L. Carlone, ROBIN, 2021): a graph of neighbours'
/// lists, peeled in linear time. No clique: it may hold more than agrees.
Chosen densest_core(const std::vector<mapping::SweptPair>& pairs, double eps_m);

/// PCL's GeometricConsistencyGrouping with a resolution of `eps_m` and sets of `least`: the largest one.
/// False where PCL is not there.
bool pcl_grouping(const std::vector<mapping::SweptPair>& pairs, double eps_m, int least, Chosen& chosen,
                  double& ms);

}  // namespace sortie::bench
