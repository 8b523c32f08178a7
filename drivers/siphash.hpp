// SPDX-License-Identifier: BSD-3-Clause
// SipHash-2-4: tells whether bytes come from somebody who knows a secret of 16 bytes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

namespace sortie::drivers {

/// A secret that both sides have.
using SipKey = std::array<std::uint8_t, 16>;

namespace detail {
struct SipState {
  std::uint64_t a, b, c, d;
  void round() noexcept {
    a += b;
    c += d;
    b = std::rotl(b, 13) ^ a;
    d = std::rotl(d, 16) ^ c;
    a = std::rotl(a, 32) + d;
    c += b;
    d = std::rotl(d, 21) ^ a;
    b = std::rotl(b, 17) ^ c;
    c = std::rotl(c, 32);
  }
};

inline std::uint64_t sip_word(const std::uint8_t* bytes) noexcept {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, 8);
  return word;
}
}  // namespace detail

/// SipHash-2-4 of `bytes` (Aumasson and Bernstein 2012, 64-bit result). No heap; about 1 ns a byte and 20 ns.
inline std::uint64_t siphash24(const SipKey& key, std::span<const std::uint8_t> bytes) noexcept {
  const std::uint64_t k0 = detail::sip_word(key.data());
  const std::uint64_t k1 = detail::sip_word(key.data() + 8);
  detail::SipState state{k0 ^ 0x736f6d6570736575u, k1 ^ 0x646f72616e646f6du, k0 ^ 0x6c7967656e657261u,
                         k1 ^ 0x7465646279746573u};
  const auto take = [&state](std::uint64_t word) {
    state.d ^= word;
    state.round();
    state.round();
    state.a ^= word;
  };
  const std::size_t whole = bytes.size() / 8 * 8;
  for (std::size_t i = 0; i < whole; i += 8) take(detail::sip_word(bytes.data() + i));
  std::uint64_t last = std::uint64_t{bytes.size()} << 56;
  for (std::size_t i = whole; i < bytes.size(); ++i) last |= std::uint64_t{bytes[i]} << (8 * (i - whole));
  take(last);
  state.c ^= 0xff;
  for (int i = 0; i < 4; ++i) state.round();
  return state.a ^ state.b ^ state.c ^ state.d;
}

}  // namespace sortie::drivers
