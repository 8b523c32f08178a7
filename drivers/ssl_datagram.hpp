// SPDX-License-Identifier: BSD-3-Clause
// A solid-state lidar in a process of its own on the same machine: lists of rays go out in datagrams, and
// what came back comes in.
//
// Payloads are the messages of drivers/wire_ssl.hpp, one a datagram; stamps on the way are CLOCK_MONOTONIC.
// That of a command is the instant whose pose it was planned for, that of an answer the end of its frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/datagram_link.hpp"
#include "drivers/ssl_port.hpp"
#include "drivers/wire_ssl.hpp"
#include "rt/describe.hpp"

namespace sortie::drivers {

// The longest list of rays and its answer need no parts.
static_assert(kSslCommandBytes <= DatagramLink::kMaxPayload && kSslReturnsBytes <= DatagramLink::kMaxPayload);

/// What the runtime's end has seen. Each datagram that the link gave out is counted in one of the lines (1).
struct SslDatagramCounters {
  std::uint64_t commands{};     ///< sent
  std::uint64_t unsent{};       ///< nobody there, or the kernel had no room
  std::uint64_t frames{};       ///< (1) taken
  std::uint64_t malformed{};    ///< (1) no answer at all, or a length or a direction that cannot be
  std::uint64_t unasked{};      ///< (1) of a command that was not sent, or of one so old that it is forgotten
  std::uint64_t repeated{};     ///< (1) of a command that was answered
  std::uint64_t overtaken{};    ///< (1) of a command older than one that was answered
  std::uint64_t mismatched{};   ///< (1) of other rays than the command's, or of another number of them
  std::uint64_t out_of_time{};  ///< (1) measured after it came, or long before
  std::uint64_t overrun{};      ///< (1) nobody took those before it
  SORTIE_FIELDS(commands, unsent, frames, malformed, unasked, repeated, overtaken, mismatched, out_of_time,
                overrun)
};

/// The runtime's end: the driver of such a device. It knows the last commands that it sent, and takes an
/// answer only if it is theirs, ray by ray, once, and in order. A refused answer changes nothing but its
/// counter. About 32 kB, no heap, nothing blocks. One thread.
class SslDatagram final : public SslPort {
 public:
  /// Datagrams that one call of poll() takes.
  static constexpr int kMostPerPoll = 16;
  /// Commands whose answers can still come.
  static constexpr std::uint32_t kRemembered = 8;
  /// A frame's stamp against its arrival: as for frames on the bus.
  static constexpr rt::Nanoseconds kMostAheadNs = 1'000'000;
  static constexpr rt::Nanoseconds kMostBehindNs = 1'000'000'000;

  /// Status and `problem` as DatagramLink::open(). Stamps count from `epoch_ns` of CLOCK_MONOTONIC.
  [[nodiscard]] Status open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem);

  /// Takes what has come. About every millisecond.
  void poll() noexcept;

  /// As SslPort says; besides: disconnected (nobody is there). Cost: one system call.
  [[nodiscard]] Status send(const rt::SslCommand& command) noexcept override;
  [[nodiscard]] Status receive(rt::SslReturns& returns) noexcept override;

  const DatagramLink& link() const noexcept { return link_; }
  const SslDatagramCounters& counters() const noexcept { return counters_; }

 private:
  void take(std::span<const std::uint8_t> payload, rt::Nanoseconds arrival_ns) noexcept;

  DatagramLink link_;
  rt::Nanoseconds epoch_ns_{};
  std::array<rt::SslCommand, kRemembered> sent_{};
  std::uint64_t sent_count_{};
  std::uint32_t answered_{};  ///< number of the newest command that was answered
  bool any_answered_{};
  std::array<rt::SslReturns, 4> waiting_{};
  std::uint32_t first_{};
  std::uint32_t count_{};
  SslDatagramCounters counters_{};
};

/// What the device's end has seen. Each datagram that the link gave out is counted in one of the lines (1).
struct SslDeviceCounters {
  std::uint64_t commands{};     ///< (1) given to the device
  std::uint64_t malformed{};    ///< (1) no command, or a length or a direction that cannot be
  std::uint64_t repeated{};     ///< (1) not newer than the one before
  std::uint64_t out_of_time{};  ///< (1) meant for a pose that is past, or far ahead
  std::uint64_t refused{};      ///< (1) the device has not taken those before
  std::uint64_t frames{};       ///< sent
  std::uint64_t unsent{};       ///< nobody there, or the kernel had no room
  SORTIE_FIELDS(commands, malformed, repeated, out_of_time, refused, frames, unsent)
};

/// The device's end, which listens: commands go on to a device behind a port of its own, its frames go back.
/// No heap after open(), nothing blocks. One thread.
class SslDatagramDevice {
 public:
  static constexpr int kMostPerPoll = 16;
  /// A command's instant against its arrival. Rays for a pose that is longer past would look elsewhere.
  static constexpr rt::Nanoseconds kMostBehindNs = 200'000'000;
  static constexpr rt::Nanoseconds kMostAheadNs = 1'000'000'000;

  /// As SslDatagram::open(); `epoch_ns` is when the device's clock read 0.
  [[nodiscard]] Status open(DatagramLinkConfig config, rt::Nanoseconds epoch_ns, std::string& problem);

  /// Hands on the commands that have come. About every millisecond.
  void deliver(SslPort& device) noexcept;
  /// Sends what the device has measured.
  void collect(SslPort& device) noexcept;

  const DatagramLink& link() const noexcept { return link_; }
  const SslDeviceCounters& counters() const noexcept { return counters_; }

 private:
  void take(std::span<const std::uint8_t> payload, rt::Nanoseconds arrival_ns, SslPort& device) noexcept;

  DatagramLink link_;
  rt::Nanoseconds epoch_ns_{};
  std::uint64_t life_{};    ///< of the runtime: each counts its commands from the beginning
  std::uint32_t newest_{};  ///< number of its newest command
  bool any_{};
  std::int64_t sent_{};
  SslDeviceCounters counters_{};
};

}  // namespace sortie::drivers
