// SPDX-License-Identifier: BSD-3-Clause
// One small interface to a CAN bus. A stub and SocketCAN sit behind it; the code above does not know which.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// Bits of CanFrame::flags.
enum CanFlags : std::uint8_t {
  kCanExtended = 1u,  ///< 29-bit identifier
  kCanRemote = 2u,    ///< remote request, no data
  kCanError = 4u,     ///< error frame: id holds the error class as Linux defines it
};

/// A classical CAN frame. 24 bytes, plain.
struct CanFrame {
  rt::Nanoseconds stamp_ns{};  ///< when the last bit was on the bus
  std::uint32_t id{};          ///< 11 or 29 bits, without flag bits
  std::uint8_t size{};         ///< bytes of data, 0..8
  std::uint8_t flags{};
  std::uint8_t data[8]{};
  SORTIE_FIELDS(stamp_ns, id, size, flags, data)
};

/// What a port has seen. All counts since the port was opened.
struct CanCounters {
  std::uint64_t sent{};
  std::uint64_t received{};
  std::uint64_t tx_refused{};  ///< send() with a full transmit queue
  std::uint64_t rx_overrun{};  ///< frames lost because nobody took them
  std::uint64_t error_frames{};
  std::uint64_t bus_off{};   ///< times the controller left the bus
  std::uint64_t reopened{};  ///< times the interface had gone, and was opened again
};

/// A node's port on a bus. Neither call blocks, allocates or throws. One thread may use a port at a time.
class CanBus {
 public:
  virtual ~CanBus() = default;
  /// Queues one frame. Status: ok, full (nothing sent, counted), malformed (size > 8 or id too wide),
  /// disconnected.
  [[nodiscard]] virtual Status send(const CanFrame& frame) noexcept = 0;
  /// Takes the oldest received frame. Status: ok, empty, disconnected.
  [[nodiscard]] virtual Status receive(CanFrame& frame) noexcept = 0;
  /// Counters of this port.
  [[nodiscard]] virtual CanCounters counters() const noexcept = 0;
};

}  // namespace sortie::drivers
