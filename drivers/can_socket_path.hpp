// SPDX-License-Identifier: BSD-3-Clause
// The one way of every CAN port to the kernel and back: sending, receiving, what errors mean, and how a port
// comes back by itself. Internal to the ports.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

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

  /// Takes ownership of a socket; who opens it again, if anybody does. Counters begin anew.
  void use(int descriptor, rt::Nanoseconds epoch_ns, Opener opener, void* context) noexcept;
  void close() noexcept;

  /// One packet. Status: ok; full; malformed; disconnected.
  [[nodiscard]] Status send(const void* packet, std::size_t bytes) noexcept;
  /// One packet of at most `room` bytes. Status: ok; empty; malformed; disconnected.
  [[nodiscard]] Status receive(void* to, std::size_t room, std::size_t& bytes,
                               rt::Nanoseconds& stamp_ns) noexcept;
  /// After a packet was understood: a frame of the bus, or an error frame with its class and first two bytes.
  void note_frame() noexcept;
  void note_error(std::uint32_t error_class, std::uint8_t controller) noexcept;

  [[nodiscard]] const CanCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  [[nodiscard]] bool bus_off() const noexcept { return bus_off_; }

 private:
  bool try_again(rt::Nanoseconds every_ns) noexcept;
  bool there() noexcept;
  Status failed(int error, Status when_busy) noexcept;

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
