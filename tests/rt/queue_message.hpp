// SPDX-License-Identifier: BSD-3-Clause
// A value that shows whether it was torn: all words follow from the first.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sortie::rt::test {

struct Message {
  std::uint64_t words[9]{};
};

inline std::uint64_t scramble(std::uint64_t x) {
  x ^= x >> 31;
  x *= 0x9e3779b97f4a7c15u;
  return x ^ (x >> 29);
}

inline Message make_message(std::uint64_t number) {
  Message message;
  message.words[0] = number;
  for (std::size_t i = 1; i < 9; ++i) message.words[i] = scramble(message.words[i - 1] + i);
  return message;
}

inline bool intact(const Message& message) {
  const Message expected = make_message(message.words[0]);
  for (std::size_t i = 0; i < 9; ++i) {
    if (message.words[i] != expected.words[i]) return false;
  }
  return true;
}

}  // namespace sortie::rt::test
