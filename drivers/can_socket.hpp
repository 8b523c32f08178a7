// SPDX-License-Identifier: BSD-3-Clause
// A port on a real CAN bus through Linux's SocketCAN (AF_CAN, raw). Where the kernel has no CAN, opening says
// so.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/can_bus.hpp"
#include "drivers/can_socket_path.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// The port. Bit rate and state of the interface belong to the system (ip link), not to this class. Frames
/// are stamped by the kernel when they arrive; the stamp is moved to CLOCK_MONOTONIC, so setting the system's
/// date does no harm. No call blocks or allocates after open(); a call costs one or three system calls. A
/// port comes back by itself, after bus-off and after its adapter was unplugged. One thread.
class SocketCan final : public CanBus {
 public:
  SocketCan() = default;
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// Opens the interface. Status: ok; not_supported (the kernel has no CAN); disconnected (no such interface,
  /// it is down, it is no CAN interface, or not allowed). `problem` then says what is wrong and the cure.
  [[nodiscard]] Status open(const SocketCanConfig& config, std::string& problem) {
    return path_.open(config, CanSocketKind::classical, problem);
  }

  /// Uses a datagram socket that carries Linux `struct can_frame`s, for gateways and tests. Takes ownership.
  /// Frames without a kernel stamp are stamped when they are taken. `opener`: who opens it again when it is
  /// gone (drivers/can_socket_path.hpp).
  void adopt(int descriptor, rt::Nanoseconds epoch_ns = 0, CanSocketPath::Opener opener = nullptr,
             void* context = nullptr) {
    path_.use(descriptor, epoch_ns, opener, context);
  }

  /// Ends the connection; both calls then give disconnected.
  void close() noexcept { path_.close(); }

  /// As CanBus. `disconnected` also while the controller is bus-off, but for a try every 100 ms, and while
  /// the interface is gone. `sent` counts frames that the kernel took.
  [[nodiscard]] Status send(const CanFrame& frame) noexcept override;
  /// As CanBus. `disconnected` when the interface went down; it may come back.
  [[nodiscard]] Status receive(CanFrame& frame) noexcept override;
  [[nodiscard]] CanCounters counters() const noexcept override { return path_.counters(); }

  /// The socket, for poll(); -1 when closed.
  [[nodiscard]] int descriptor() const noexcept { return path_.descriptor(); }
  /// The controller reported bus-off, and nothing since says that it is back.
  [[nodiscard]] bool bus_off() const noexcept { return path_.bus_off(); }

 private:
  CanSocketPath path_;
};

}  // namespace sortie::drivers
