// SPDX-License-Identifier: BSD-3-Clause
// Random numbers of the test bench: the same on every compiler and processor, and cheap to seed per event.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "rt/math.hpp"

namespace sortie::hil {

/// One step of SplitMix64: scrambles a counter into 64 well mixed bits. Used to seed.
constexpr std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// xoshiro256** (Blackman and Vigna, 2018), seeded by SplitMix64. 56 bytes, no heap. Draw once per full
/// expression: the order of two draws in one expression is the compiler's choice.
class Random {
 public:
  /// `stream` separates sources that share a seed (sensors, scans): no draw of one moves another.
  explicit constexpr Random(std::uint64_t seed = 1, std::uint64_t stream = 0) {
    std::uint64_t first = seed;
    std::uint64_t second = stream ^ 0xd1342543de82ef95u;
    for (std::uint64_t& word : state_) word = splitmix64(first) ^ std::rotl(splitmix64(second), 23);
  }

  /// Continues from a given state, which must not be all zero: for comparison with published sequences.
  static constexpr Random from_state(std::uint64_t a, std::uint64_t b, std::uint64_t c, std::uint64_t d) {
    Random random;
    random.state_[0] = a;
    random.state_[1] = b;
    random.state_[2] = c;
    random.state_[3] = d;
    return random;
  }

  /// 64 random bits. Cost: about 2 ns.
  constexpr std::uint64_t bits() {
    const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }

  /// Uniform in [0, 1), all multiples of 2^-53.
  constexpr double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

  /// Uniform in [low, high).
  constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal deviate by Box and Muller: two from one pair of uniforms, the second is kept for the
  /// next call. |value| <= 8.6. Cost: about 40 ns.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double u = 1.0 - uniform();  // in (0, 1]: the logarithm is finite
    const double angle = 6.283185307179586 * uniform();
    const double radius = std::sqrt(-2.0 * rt::log(u));
    const rt::SinCos turn = rt::sincos(angle);
    spare_ = radius * turn.sin;
    has_spare_ = true;
    return radius * turn.cos;
  }

  /// True with the given probability. Always one draw, also for 0 and 1.
  constexpr bool chance(double probability) { return uniform() < probability; }

 private:
  std::uint64_t state_[4]{};
  double spare_{};
  bool has_spare_{};
};

}  // namespace sortie::hil
