// SPDX-License-Identifier: BSD-3-Clause
// Frames for the tests of the CAN bus in memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "drivers/can_stub.hpp"

namespace sortie::drivers::rig {

/// Nanoseconds a bit at 500 kbit/s.
inline constexpr std::int64_t kBit = 2000;

/// A frame of one byte, ready at a time.
inline CanFrame frame(std::uint32_t id, std::int64_t ready_ns = 0, std::uint8_t tag = 0) {
  CanFrame f;
  f.id = id;
  f.stamp_ns = ready_ns;
  f.size = 1;
  f.data[0] = tag;
  return f;
}

/// All that waits at a node.
inline std::vector<CanFrame> drain(CanBus& bus) {
  std::vector<CanFrame> all;
  CanFrame f;
  while (bus.receive(f) == Status::ok) all.push_back(f);
  return all;
}

/// Equal in every field, stamps included.
inline bool same(const CanFrame& a, const CanFrame& b) {
  return a.stamp_ns == b.stamp_ns && a.id == b.id && a.size == b.size && a.flags == b.flags &&
         std::equal(a.data, a.data + 8, b.data);
}

}  // namespace sortie::drivers::rig
