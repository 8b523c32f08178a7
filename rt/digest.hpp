// SPDX-License-Identifier: BSD-3-Clause
// Digests of values: xxhash64 over the canonical form, so that padding and struct layout never matter.
#pragma once

#include <cstddef>
#include <cstdint>

#define XXH_INLINE_ALL
#define XXH_FORCE_MEMORY_ACCESS 0  // by memcpy: callers hand over values of any type, not bytes alone
#include <xxhash.h>

#include "rt/fields.hpp"

namespace sortie::rt {

/// xxhash64 of `size` bytes. No heap, no state. Cost: about 0.1 ns a byte above a floor of some 10 ns.
inline std::uint64_t digest_bytes(const void* bytes, std::size_t size, std::uint64_t seed = 0) {
  return XXH64(bytes, size, seed);
}

/// xxhash64 of the canonical form of `value`. Memory: canonical_size<T>() bytes of stack.
template <Described T>
inline std::uint64_t digest_of(const T& value, std::uint64_t seed = 0) {
  std::uint8_t bytes[canonical_size<T>()];
  return digest_bytes(bytes, encode_canonical(value, bytes), seed);
}

/// Folds one job's digest into a chain. Two runs with equal chains had equal outputs at every tick before.
inline std::uint64_t chain_digest(std::uint64_t chain, std::uint64_t tick, std::uint64_t digest) {
  const std::uint64_t link[3] = {chain, tick, digest};
  return digest_bytes(link, sizeof(link));
}

}  // namespace sortie::rt
