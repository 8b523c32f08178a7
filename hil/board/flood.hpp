// SPDX-License-Identifier: BSD-3-Clause
// Many frames both ways between two SocketCAN ports of a board, by a periodic real-time thread.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// What is sent. The far end is a process of its own, of lower real-time priority; it answers every frame.
struct FloodConfig {
  std::string near = "vcan0";    ///< interface of the real-time thread
  std::string far = "vcan0";     ///< interface of the process that answers
  std::uint32_t frames{100000};  ///< each way
  std::uint32_t per_ms{10};
};

/// Sends, takes the answers and prints one JSON object: sent, received, out_of_order, lost, refused,
/// heap_calls, overrun, page_faults, releases, late_{min,p50,p99,max}_ns (wake-up after its release),
/// work_max_ns. Exit code 0 when every frame came back in order and nothing took memory. Linux, root.
int flood(const FloodConfig& config);

}  // namespace sortie::hil
