// SPDX-License-Identifier: BSD-3-Clause
// CAN FD: a frame of up to 64 bytes, and a port for both kinds of frames on a real bus. The robot's own
// devices speak classical CAN and pay nothing for it: its frames, queues and logs stay as they are.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/can_bus.hpp"
#include "drivers/can_socket.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// More bits for CanFdFrame::flags, beside CanFlags.
enum CanFdFlags : std::uint8_t {
  kCanFd = 8u,              ///< an FD frame; without it a classical one
  kCanBitRateSwitch = 16u,  ///< FD: data at the faster bit rate
  kCanErrorState = 32u,     ///< FD: the sender is error passive
};

/// A frame of either kind. 80 bytes, plain.
struct CanFdFrame {
  rt::Nanoseconds stamp_ns{};  ///< when it arrived
  std::uint32_t id{};          ///< 11 or 29 bits, without flag bits
  std::uint8_t size{};         ///< bytes of data: 0..8; FD also 12, 16, 20, 24, 32, 48, 64
  std::uint8_t flags{};        ///< CanFlags and CanFdFlags
  std::uint8_t data[64]{};
};

/// Smallest size of an FD frame that holds `bytes`, at most 64: an FD frame of 13 bytes has 16.
constexpr std::uint8_t can_fd_size(std::uint8_t bytes) {
  if (bytes <= 8) return bytes;
  if (bytes <= 24) return static_cast<std::uint8_t>((bytes + 3) / 4 * 4);
  return bytes <= 32 ? std::uint8_t{32} : bytes <= 48 ? std::uint8_t{48} : std::uint8_t{64};
}

/// Whether a bus can carry it: size, width of the identifier, flags that go together (FD has no remote
/// frames).
[[nodiscard]] bool can_fd_frame_valid(const CanFdFrame& frame) noexcept;

/// The same frame for who knows both kinds, and back: not_supported for an FD frame; `out` is unchanged then.
[[nodiscard]] CanFdFrame widened(const CanFrame& frame) noexcept;
[[nodiscard]] Status narrowed(const CanFdFrame& frame, CanFrame& out) noexcept;

/// A port for frames of both kinds through SocketCAN. Promises, stamps and counters are those of SocketCan:
/// no call blocks or allocates after open(). One thread.
class CanFdSocket {
 public:
  CanFdSocket() = default;
  CanFdSocket(const CanFdSocket&) = delete;
  CanFdSocket& operator=(const CanFdSocket&) = delete;

  /// As SocketCan::open; not_supported also where the interface carries no FD frames.
  [[nodiscard]] Status open(const SocketCanConfig& config, std::string& problem) {
    return path_.open(config, CanSocketKind::fd, problem);
  }
  /// Uses a datagram socket that carries Linux `struct can_frame`s and `struct canfd_frame`s. Takes
  /// ownership.
  void adopt(int descriptor, rt::Nanoseconds epoch_ns = 0, CanSocketPath::Opener opener = nullptr,
             void* context = nullptr) {
    path_.use(descriptor, epoch_ns, opener, context);
  }
  void close() noexcept { path_.close(); }

  /// Status: ok, full (nothing sent, counted), malformed (see can_fd_frame_valid), disconnected (also while
  /// bus-off).
  [[nodiscard]] Status send(const CanFdFrame& frame) noexcept;
  /// The oldest frame of either kind. Status: ok, empty, malformed (a packet that is no frame, passed over),
  /// disconnected.
  [[nodiscard]] Status receive(CanFdFrame& frame) noexcept;
  [[nodiscard]] CanCounters counters() const noexcept { return path_.counters(); }
  /// The socket, for poll(); -1 when closed.
  [[nodiscard]] int descriptor() const noexcept { return path_.descriptor(); }

 private:
  CanSocketPath path_;
};

}  // namespace sortie::drivers
