// SPDX-License-Identifier: BSD-3-Clause
// The targets' sizes side by side, so that most of them need no further look.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

#include "mapping/recognition/target_record.hpp"
#include "rt/arena.hpp"

namespace sortie::mapping {

/// The first three steps of every target's descriptor, in columns; 64 are tested in a loop without branches,
/// which compilers turn into vectors. Memory: 4 bytes a target. No
/// heap.
class TargetSizes {
 public:
  static constexpr std::uint32_t kBlock = 64;

  TargetSizes(std::uint32_t targets, rt::Arena& arena) {
    const std::size_t padded = (std::size_t{targets} + kBlock - 1) / kBlock * kBlock;
    const auto all = arena.make_array<std::uint8_t>("target_sizes", 4 * padded);
    if (all.empty()) return;
    kept_ = all.first(padded);
    for (std::size_t i = 0; i < 3; ++i) step_[i] = all.subspan((i + 1) * padded, padded);
  }

  void put(TargetIndex target, const TargetRecord& record) {
    kept_[target] = record.state == TargetState::free ? 0 : 1;
    for (int i = 0; i < 3; ++i) step_[i][target] = record.descriptor.step[i];
  }
  void clear() { std::fill(kept_.begin(), kept_.end(), std::uint8_t{0}); }

  /// Targets of the block that begins with `first`, a multiple of kBlock below the number of targets, whose
  /// three sizes are within `steps` of the descriptor's: a bit each, the lowest for `first`.
  std::uint64_t passing(std::uint32_t first, const SegmentDescriptor& descriptor, std::uint32_t steps) const {
    std::uint8_t low[3], wide[3];
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t middle = descriptor.step[i];
      low[i] = static_cast<std::uint8_t>(middle > steps ? middle - steps : 0);
      wide[i] = static_cast<std::uint8_t>(std::min(middle + steps, 255u) - low[i]);
    }
    std::uint8_t pass[kBlock];
    test(&kept_[first], &step_[0][first], &step_[1][first], &step_[2][first], low, wide, pass);
    static_assert(std::endian::native == std::endian::little, "the first byte is the lowest");
    std::uint64_t bits = 0;
    for (std::uint32_t i = 0; i < kBlock; i += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, &pass[i], sizeof(eight));
      bits |= (eight * kGather >> 56) << i;
    }
    return bits;
  }

 private:
  /// Brings the lowest bits of eight bytes together in the highest byte of the product; no two meet
  /// elsewhere.
  static constexpr std::uint64_t kGather = 0x0102040810204080;

  static std::uint8_t is_within(std::uint8_t step, std::uint8_t low, std::uint8_t wide) {
    return static_cast<std::uint8_t>(step - low) <= wide ? 1 : 0;
  }
  static void test(const std::uint8_t* kept, const std::uint8_t* a, const std::uint8_t* b,
                   const std::uint8_t* c, const std::uint8_t (&low)[3], const std::uint8_t (&wide)[3],
                   std::uint8_t (&pass)[kBlock]) {
    // As values: what is written might else be the limits, and nothing would be turned into vectors.
    const std::uint8_t low_a = low[0], low_b = low[1], low_c = low[2];
    const std::uint8_t wide_a = wide[0], wide_b = wide[1], wide_c = wide[2];
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      const int within = kept[i] & is_within(a[i], low_a, wide_a) & is_within(b[i], low_b, wide_b) &
                         is_within(c[i], low_c, wide_c);
      pass[i] = static_cast<std::uint8_t>(within);
    }
  }

  std::span<std::uint8_t> kept_;
  std::span<std::uint8_t> step_[3];
};

}  // namespace sortie::mapping
