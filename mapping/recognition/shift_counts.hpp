// SPDX-License-Identifier: BSD-3-Clause
// Counts for many shifts of a row at a time: bit i of all words together is the count of shift i.
#pragma once

#include <bit>
#include <cstdint>

namespace sortie::mapping {

/// 64 counters a word, up to 1,023 each, that are counted up by words of one bit a counter. Eight words go in
/// at a time, through a tree of adders (S. Harley and R. Seal's count of bits, here of each bit apart): some
/// six operations a word. What add() was given counts once flush() was called.
template <int kWords>
class ShiftCounts {
 public:
  using Word = std::uint64_t;
  static constexpr int kBits = 10;

  void clear() { *this = {}; }

  void add(const Word (&bits)[kWords]) {
    for (int w = 0; w < kWords; ++w) waiting_[size_][w] = bits[w];
    if (++size_ == kBatch) add_batch();
  }
  void flush() {
    if (size_ == 0) return;
    for (; size_ < kBatch; ++size_) {
      for (int w = 0; w < kWords; ++w) waiting_[size_][w] = 0;
    }
    add_batch();
  }

  /// Of shift 64 `word` + `bit`.
  std::uint32_t count(int word, unsigned bit) const {
    std::uint32_t sum = 0;
    for (int b = 0; b < kBits; ++b) sum |= static_cast<std::uint32_t>(planes_[b][word] >> bit & 1) << b;
    return sum;
  }
  /// The shifts of a word that count `least` or more.
  Word at_least(int word, std::uint32_t least) const {
    Word above = 0, same = ~Word{0};
    for (int b = kBits - 1; b >= 0; --b) {
      const Word ours = planes_[b][word];
      if ((least >> b & 1) == 0) {
        above |= same & ours;
        same &= ~ours;
      } else {
        same &= ours;
      }
    }
    return above | same;
  }
  /// The largest count of a word's shifts, and which of them have it.
  std::uint32_t most(int word, Word& which) const {
    std::uint32_t value = 0;
    which = ~Word{0};
    for (int b = kBits - 1; b >= 0; --b) {
      const Word with = which & planes_[b][word];
      if (with == 0) continue;
      which = with;
      value |= 1u << b;
    }
    return value;
  }

 private:
  static constexpr int kBatch = 8;

  static void full_add(Word& carry, Word& sum, Word a, Word b) {
    const Word half = sum ^ a;
    carry = (sum & a) | (half & b);
    sum = half ^ b;
  }
  void add_batch() {
    for (int w = 0; w < kWords; ++w) {
      Word &ones = planes_[0][w], &twos = planes_[1][w], &fours = planes_[2][w];
      Word two_a, two_b, four_a, four_b, carry;
      full_add(two_a, ones, waiting_[0][w], waiting_[1][w]);
      full_add(two_b, ones, waiting_[2][w], waiting_[3][w]);
      full_add(four_a, twos, two_a, two_b);
      full_add(two_a, ones, waiting_[4][w], waiting_[5][w]);
      full_add(two_b, ones, waiting_[6][w], waiting_[7][w]);
      full_add(four_b, twos, two_a, two_b);
      full_add(carry, fours, four_a, four_b);
      for (int b = 3; b < kBits; ++b) {
        const Word next = planes_[b][w] & carry;
        planes_[b][w] ^= carry;
        carry = next;
      }
    }
    size_ = 0;
  }

  Word planes_[kBits][kWords]{};
  Word waiting_[kBatch][kWords]{};
  int size_{};
};

}  // namespace sortie::mapping
