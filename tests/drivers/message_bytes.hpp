// SPDX-License-Identifier: BSD-3-Clause
// Message bytes from lcm-gen's code and from ours, for comparison.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/status.hpp"

namespace sortie::test {

using Bytes = std::vector<std::uint8_t>;

template <class Message>
Bytes generated_bytes(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  REQUIRE(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())) == static_cast<int>(bytes.size()));
  return bytes;
}

// Encodes into a buffer that is just large enough, and shows that one byte less is refused.
template <class Encode>
Bytes exact(Encode&& encode) {
  Bytes bytes(4096);
  std::size_t size = 0;
  REQUIRE(encode(std::span<std::uint8_t>(bytes), size) == Status::ok);
  bytes.resize(size);
  Bytes smaller(size - 1);
  std::size_t none = 1;
  REQUIRE(encode(std::span<std::uint8_t>(smaller), none) == Status::full);
  REQUIRE(none == 0);
  return bytes;
}

}  // namespace sortie::test
