// SPDX-License-Identifier: BSD-3-Clause
// How a port on a real CAN bus is opened.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rt/time.hpp"

namespace sortie::drivers {

/// Frames with (id & mask) == (filter.id & mask) of the right width come through.
struct SocketCanFilter {
  std::uint32_t id{};
  std::uint32_t mask{};
  bool extended{};
};

/// How a port is opened.
struct SocketCanConfig {
  std::string interface = "can0";
  std::vector<SocketCanFilter> filters{};  ///< none: every frame comes through; 32 at most
  bool error_frames = true;                ///< controller errors arrive as frames with kCanError
  rt::Nanoseconds epoch_ns = 0;            ///< CLOCK_MONOTONIC at the start of the run; stamps count from it
  int receive_buffer_bytes = 0;            ///< 0: the kernel's default (some 270 frames)
};

}  // namespace sortie::drivers
