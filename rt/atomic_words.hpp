// SPDX-License-Identifier: BSD-3-Clause
// Plain values copied through atomic words of 32 or 64 bits: what a reader may see half-written, without a
// data race. A counter beside the words tells the reader afterwards whether to believe what it copied.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sortie::rt {

/// Words that a T takes.
template <class T, class Raw = std::uint32_t>
inline constexpr std::uint32_t kWordsOf = static_cast<std::uint32_t>((sizeof(T) + sizeof(Raw) - 1) /
                                                                     sizeof(Raw));

/// Stores a value. Every word is a release: who sees it sees all that the writer did before, the counter's
/// step above all. Free on x86-64, one stlr a word on ARMv8. (GCC at -O2 unrolls nothing by itself.)
template <class T, class Word>
void store_words(Word* words, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>, "copied word by word");
  using Raw = typename Word::value_type;
  const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
  constexpr std::uint32_t kWhole = sizeof(T) / sizeof(Raw);
#pragma GCC unroll 16
  for (std::uint32_t i = 0; i < kWhole; ++i) {
    Raw word;
    std::memcpy(&word, bytes + sizeof(Raw) * i, sizeof(Raw));
    words[i].store(word, std::memory_order_release);
  }
  if constexpr (sizeof(T) % sizeof(Raw) != 0) {
    Raw word = 0;
    std::memcpy(&word, bytes + sizeof(Raw) * kWhole, sizeof(T) % sizeof(Raw));
    words[kWhole].store(word, std::memory_order_release);
  }
}

/// Loads the words of a T, possibly of two values: look at the counter before unpacking them.
template <class T, class Word>
auto load_words(const Word* words) {
  using Raw = typename Word::value_type;
  std::array<Raw, kWordsOf<T, Raw>> raw;
#pragma GCC unroll 16
  for (std::uint32_t i = 0; i < kWordsOf<T, Raw>; ++i) raw[i] = words[i].load(std::memory_order_acquire);
  return raw;
}

/// The value in words that were found whole.
template <class T, class Raw, std::size_t kCount>
void unpack_words(const std::array<Raw, kCount>& raw, T& value) {
  static_assert(kCount == kWordsOf<T, Raw>);
  std::memcpy(static_cast<void*>(&value), raw.data(), sizeof(T));
}

}  // namespace sortie::rt
