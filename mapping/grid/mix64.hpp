// SPDX-License-Identifier: BSD-3-Clause
// Mixes bits, for digests of maps and for draws by number.
#pragma once

#include <cstdint>

namespace sortie::mapping {

/// Mixes 64 bits so that every input bit reaches every output bit (MurmurHash3's finaliser, constants of
/// Stafford's variant 13). A bijection: different inputs give different outputs.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

}  // namespace sortie::mapping
