// SPDX-License-Identifier: BSD-3-Clause
// The one way of every CAN port to the kernel and back: opening, sending, receiving, what errors mean, and
// how a port comes back by itself. Internal to the ports, but for the configuration.
#pragma once

#include <cstddef>
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
  std::vector<SocketCanFilter> filters{};  ///< none: every frame comes through; 32 at most
  bool error_frames = true;                ///< controller errors arrive as frames with kCanError
  rt::Nanoseconds epoch_ns = 0;            ///< CLOCK_MONOTONIC at the start of the run; stamps count from it
  int receive_buffer_bytes = 0;            ///< 0: the kernel's default (some 270 frames)
};

/// Which frames a socket carries.
enum class CanSocketKind : std::uint8_t { classical, fd };

/// Identifier and CanFlags of a frame as the kernel has them in one word, and back.
[[nodiscard]] std::uint32_t to_kernel_id(std::uint32_t id, std::uint8_t flags) noexcept;
[[nodiscard]] std::uint32_t from_kernel_id(std::uint32_t kernel_id, std::uint8_t& flags) noexcept;

/// A socket, and what became of it. The rules:
/// - Bus-off ends by the first sign of life of the bus: a restart, a controller that says it is active, any
///   frame that is heard. That the kernel takes a frame of ours is none: an interface whose carrier is off
///   has a queue that takes ten, or one that takes all and drops them. A frame is put out every 100 ms all
///   the same, refused to who sent it, so that somebody answers where the frame that told of the restart was
///   lost.
/// - An interface that is down comes back with the same socket. One that was unplugged has another number
///   when it is back: the socket is opened anew, tried every 250 ms, without memory and without waiting.
/// One thread; no call blocks or allocates after start-up.
class CanSocketPath {
 public:
  /// Opens the interface again. A descriptor, or -1.
  using Opener = int (*)(void*);

  CanSocketPath() = default;
  ~CanSocketPath() { close(); }
  CanSocketPath(const CanSocketPath&) = delete;
  CanSocketPath& operator=(const CanSocketPath&) = delete;

  /// As SocketCan::open. With `fd` also not_supported: the interface carries no FD frames.
  [[nodiscard]] Status open(const SocketCanConfig& config, CanSocketKind kind, std::string& problem);
  /// Takes ownership of a socket; who opens it again, if anybody does. Counters begin anew.
  void use(int descriptor, rt::Nanoseconds epoch_ns, Opener opener, void* context) noexcept;
  void close() noexcept;

  /// One packet. Status: ok; full; malformed; disconnected.
  [[nodiscard]] Status send(const void* packet, std::size_t bytes) noexcept;
  /// One packet of at most `room` bytes. Status: ok; empty; malformed; disconnected.
  [[nodiscard]] Status receive(void* to, std::size_t room, std::size_t& bytes,
                               rt::Nanoseconds& stamp_ns) noexcept;
  /// After a packet was understood: a frame of the bus, or an error frame, whose `id` is its class and
  /// `controller` its second byte.
  void note(std::uint8_t flags, std::uint32_t id, std::uint8_t controller) noexcept;

  [[nodiscard]] const CanCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  [[nodiscard]] bool bus_off() const noexcept { return bus_off_; }

 private:
  bool try_again(rt::Nanoseconds every_ns) noexcept;
  bool there() noexcept;
  Status failed(int error, Status when_busy) noexcept;

  SocketCanConfig config_;  // to open it again
  CanSocketKind kind_{};
  int descriptor_{-1};
  rt::Nanoseconds epoch_ns_{};
  Opener opener_{};
  void* context_{};
  bool bus_off_{};
  bool gone_{};  // the interface does not exist any more
  rt::Nanoseconds tried_ns_{};
  std::uint32_t kernel_overruns_{};
  CanCounters counters_{};
};

}  // namespace sortie::drivers
