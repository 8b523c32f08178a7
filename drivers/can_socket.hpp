// SPDX-License-Identifier: BSD-3-Clause
// A port on a real CAN bus through Linux's SocketCAN (AF_CAN, raw). Compiled everywhere; where the kernel has
// no CAN, opening says so.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/can_bus.hpp"
#include "rt/status.hpp"
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
  std::vector<SocketCanFilter> filters{};  ///< none: every frame comes through
  bool error_frames = true;                ///< controller errors arrive as frames with kCanError
  rt::Nanoseconds epoch_ns = 0;            ///< CLOCK_MONOTONIC at the start of the run; stamps count from it
  int receive_buffer_bytes = 0;            ///< 0: the kernel's default (some 270 frames)
};

/// The port. Bit rate and state of the interface belong to the system (ip link), not to this class. Frames
/// are stamped by the kernel when they arrive; the stamp is moved to CLOCK_MONOTONIC, so setting the system's
/// date does no harm. No call blocks or allocates after open(); a call costs one or three system calls. One
/// thread.
class SocketCan final : public CanBus {
 public:
  SocketCan() = default;
  ~SocketCan() override;
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// Opens the interface. Status: ok; not_supported (the kernel has no CAN); disconnected (no such interface,
  /// it is down, it is no CAN interface, or not allowed). `problem` then says what is wrong and the cure.
  [[nodiscard]] Status open(const SocketCanConfig& config, std::string& problem);

  /// Uses a datagram socket that carries Linux `struct can_frame`s, for gateways and tests. Takes ownership.
  /// Frames without a kernel stamp are stamped when they are taken.
  void adopt(int descriptor, rt::Nanoseconds epoch_ns = 0);

  /// Ends the connection; both calls then give disconnected.
  void close() noexcept;

  /// As CanBus. `disconnected` also while the controller is bus-off. `sent` counts frames that the kernel
  /// took.
  [[nodiscard]] Status send(const CanFrame& frame) noexcept override;
  /// As CanBus. `disconnected` when the interface went down; it may come back.
  [[nodiscard]] Status receive(CanFrame& frame) noexcept override;
  [[nodiscard]] CanCounters counters() const noexcept override { return counters_; }

  /// The socket, for poll(); -1 when closed.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  /// The controller reported bus-off and no restart since.
  [[nodiscard]] bool bus_off() const noexcept { return bus_off_; }

 private:
  void note_error_frame(const CanFrame& frame) noexcept;
  void note_overruns(std::uint32_t kernel_total) noexcept;

  int descriptor_{-1};
  rt::Nanoseconds epoch_ns_{};
  bool bus_off_{};
  std::uint32_t kernel_overruns_{};
  CanCounters counters_{};
};

}  // namespace sortie::drivers
