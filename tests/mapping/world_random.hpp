// SPDX-License-Identifier: BSD-3-Clause
// Random numbers of tests and benchmarks of the map.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace sortie::tests {

/// Random numbers that are the same everywhere.
class WorldRandom {
 public:
  explicit WorldRandom(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  float coordinate(double low, double high) { return static_cast<float>(between(low, high)); }
  /// Nearly normal, unit variance: twelve draws.
  double normal() {
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) sum += between(0, 1);
    return sum;
  }
  template <class T>
  void shuffle(std::vector<T>& all) {
    for (std::size_t i = all.size(); i > 1; --i)
      std::swap(all[i - 1], all[below(static_cast<std::uint32_t>(i))]);
  }

 private:
  std::mt19937 engine_;
};

}  // namespace sortie::tests
