// SPDX-License-Identifier: BSD-3-Clause
// How far two partitions of the same elements agree.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace sortie::bench {

/// Pairs among `n`.
inline double pairs_of(double n) { return 0.5 * n * (n - 1); }

/// Adjusted Rand index of two partitions: 1 where they are the same, 0 as far as chance would agree. `a` and
/// `b` hold a label an element. Two partitions that leave nothing to chance are 1 (Hubert and Arabie 1985).
inline double adjusted_rand_index(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::unordered_map<std::uint64_t, double> both;
  std::unordered_map<std::uint32_t, double> in_a;
  std::unordered_map<std::uint32_t, double> in_b;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both[std::uint64_t{a[i]} << 32 | b[i]] += 1;
    in_a[a[i]] += 1;
    in_b[b[i]] += 1;
  }
  // Sums of whole numbers below 2^53: the order of a hash table does not matter.
  double common = 0;
  double of_a = 0;
  double of_b = 0;
  for (const auto& one : both) common += pairs_of(one.second);
  for (const auto& one : in_a) of_a += pairs_of(one.second);
  for (const auto& one : in_b) of_b += pairs_of(one.second);
  const double all = pairs_of(static_cast<double>(a.size()));
  if (!(all > 0)) return 1;
  const double chance = of_a * of_b / all;
  const double most = 0.5 * (of_a + of_b);
  return most == chance ? 1 : (common - chance) / (most - chance);
}

}  // namespace sortie::bench
