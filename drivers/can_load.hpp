// SPDX-License-Identifier: BSD-3-Clause
// How full a CAN bus is at worst, and how long each frame may take to get through. Worked out before the run
// from periods, sizes and priorities.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rt/time.hpp"

namespace sortie::drivers {

/// A frame that comes again and again.
struct CanStream {
  std::string name;
  std::uint32_t id{};
  bool extended{};
  std::uint8_t size{};          ///< bytes of data, 0 to 8
  rt::Nanoseconds period_ns{};  ///< shortest time between two
  rt::Nanoseconds jitter_ns{};  ///< how much later than its period says it may be handed to the controller
  /// Frames of one number leave in the order in which they were handed over, as through one SocketCAN
  /// interface. Below 0: the controller sends its most urgent frame first, or has no other.
  int queue{-1};
  /// Handed over when the frame with this index has arrived (an answer to a SYNC); below 0: by its own clock.
  int after{-1};
};

/// What became of a stream.
struct CanStreamLoad {
  rt::Nanoseconds bus_ns{};    ///< one frame at its longest, intermission included
  double share{};              ///< of the bus
  rt::Nanoseconds worst_ns{};  ///< from the moment it is due to its last bit; below 0: without bound
};

/// The whole bus.
struct CanLoad {
  double share{};  ///< above 1 it cannot work
  std::vector<CanStreamLoad> streams;
};

/// Worst-case load and response times of a bus without errors, every frame stuffed as badly as any content
/// can make it. Response times after Davis, Burns, Bril and Lukkien, "Controller Area Network (CAN)
/// schedulability analysis: refuted, revisited and revised" (Real-Time Systems 35, 2007), eq. 10 to 13;
/// frames that share a queue in the manner of Davis, Kollmann, Pollex and Slomka, "Schedulability analysis
/// for Controller Area Network (CAN) with FIFO queues, priority queues and gateways" (Real-Time Systems 49,
/// 2013): a frame waits for all that its queue took before, at the urgency of the least urgent frame in the
/// queue, and disturbs others as late as it came to the queue's head. Never too low; exact without queues. A
/// frame that could still wait when the next of its kind is handed over by more than its period has no bound
/// here.
///
/// Start-up code. Throws std::runtime_error for what no bus has: a bit rate that is 0 or does not divide 1e9,
/// an identifier that is too wide or given twice, more than 8 bytes, a period of 0, a negative jitter, an
/// `after` that names no other stream. Cost: milliseconds for 50 streams.
CanLoad can_load(std::uint32_t bitrate, std::span<const CanStream> streams);

}  // namespace sortie::drivers
