// SPDX-License-Identifier: BSD-3-Clause
// A CAN bus between two processes of one machine where the kernel has no vcan: frames in datagrams.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/can_bus.hpp"
#include "drivers/datagram_link.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers {

/// Counts of such a bus beside those of its link.
struct CanDatagramCounters {
  std::uint64_t malformed{};  ///< datagrams of the peer that hold no classical CAN frame
  SORTIE_FIELDS(malformed)
};

/// A port on a bus of two nodes. Payload of a datagram: u32 identifier, u8 size, u8 flags, 8 bytes of data.
/// There is no arbitration and no bit rate: what needs those lets a CanStub time the frames first. Frames are
/// stamped by the kernel when they arrive, as SocketCan's. A frame is lost where the receiver's buffer is
/// full, and that is counted, as on a bus. No call blocks or allocates after open(). One thread.
class CanDatagram final : public CanBus {
 public:
  static constexpr std::size_t kPayload = 14;

  /// Opens a port; `config.purpose` is set here. `epoch_ns`: CLOCK_MONOTONIC at the start of the run, stamps
  /// count from it. Status and `problem` as DatagramLink::open().
  [[nodiscard]] Status open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem);
  /// Leaves the bus.
  void close() noexcept { link_.close(); }

  /// As CanBus. `disconnected` also while nobody is there to hear it.
  [[nodiscard]] Status send(const CanFrame& frame) noexcept override;
  [[nodiscard]] Status receive(CanFrame& frame) noexcept override;
  /// `rx_overrun` holds everything that was sent and never came.
  [[nodiscard]] CanCounters counters() const noexcept override;

  const DatagramLink& link() const noexcept { return link_; }
  CanDatagramCounters datagram_counters() const noexcept { return counters_; }

 private:
  DatagramLink link_;
  rt::Nanoseconds epoch_ns_{};
  CanDatagramCounters counters_{};
};

}  // namespace sortie::drivers
