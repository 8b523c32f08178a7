// SPDX-License-Identifier: BSD-3-Clause
// Two programs on one machine that send each other datagrams on the loopback: a runtime and the plant that it
// drives. Neither waits for the other, and neither takes what is not the other's.
//
// Form of a datagram, big endian: u32 'SrtL', u8 version, u8 purpose, u8 kind (1 hello, 2 data, 3 bye), u8 0,
// u64 sender's session, u64 receiver's session (0 in a hello), u32 number, payload.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "rt/describe.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// What a link carries. Ends of different purposes do not hear each other.
enum class LinkPurpose : std::uint8_t { can = 1, scans = 2, ssl = 3 };

/// How an end is opened.
struct DatagramLinkConfig {
  LinkPurpose purpose{LinkPurpose::can};
  std::uint16_t port{};     ///< on 127.0.0.1, of the end that listens
  bool listens{};           ///< this is that end; the other one may come, go and come again
  std::uint64_t session{};  ///< of this end's life: a number that nobody can guess, not 0
  rt::Nanoseconds hello_every_ns{50'000'000};  ///< of the end that does not listen
  rt::Nanoseconds silence_ns{500'000'000};     ///< after so long without a datagram there is no peer
  int receive_buffer_bytes{1 << 20};           ///< asked of the kernel, which may grant less
};

/// What an end has seen. Each datagram that was taken from the socket is counted in one of the lines (1).
struct DatagramLinkCounters {
  std::uint64_t sent{};
  std::uint64_t greetings_sent{};  ///< of those
  std::uint64_t send_refused{};    ///< the kernel had no room; nothing was sent
  std::uint64_t send_unheard{};    ///< there was no peer; nothing was sent
  std::uint64_t data{};            ///< (1) given out
  std::uint64_t greetings{};       ///< (1) hello and bye of the peer
  std::uint64_t foreign{};        ///< (1) no datagram of such a link, or from another address than the peer's
  std::uint64_t oversized{};      ///< (1) longer than any of this link
  std::uint64_t wrong_session{};  ///< (1) of another life of either end, or a second peer beside a living one
  std::uint64_t repeated{};       ///< (1) a number that was there before, or is overtaken
  std::uint64_t lost{};           ///< numbers that never came
  std::uint64_t overruns{};       ///< datagrams that the kernel dropped because nobody took them in time
  std::uint64_t peers{};          ///< lives of the other end that were met
  SORTIE_FIELDS(sent, greetings_sent, send_refused, send_unheard, data, greetings, foreign, oversized,
                wrong_session, repeated, lost, overruns, peers)
};

/// One end. The end that does not listen greets the other every 50 ms and is answered, so either may be
/// started first; the listening end takes one peer at a time, and another one only when that has said bye or
/// has been silent. Whoever does not hold the port, nor knows the session numbers, is refused and counted. No
/// call blocks, allocates or throws after open(); about 17 kB. One thread.
class DatagramLink {
 public:
  static constexpr std::size_t kHeadBytes = 28;
  static constexpr std::size_t kMaxPayload = 8192;
  /// Refused datagrams that one call of receive() gets rid of: so a flood cannot hold the caller.
  static constexpr int kMostRefusedPerCall = 64;

  DatagramLink() = default;
  ~DatagramLink() { close(); }
  DatagramLink(const DatagramLink&) = delete;
  DatagramLink& operator=(const DatagramLink&) = delete;

  /// Opens this end. Status: ok; out_of_range (port or session 0); disconnected (the port is taken, or the
  /// system refuses). `problem` then says what is wrong and the cure.
  [[nodiscard]] Status open(const DatagramLinkConfig& config, std::string& problem);
  /// Says bye to the peer and closes.
  void close() noexcept;

  /// Sends one datagram to the peer. Status: ok; full (the kernel has no room); disconnected (closed, or no
  /// peer); out_of_range (more than kMaxPayload). Cost: one system call.
  [[nodiscard]] Status send(std::span<const std::uint8_t> payload) noexcept;

  /// Takes the oldest datagram of the peer, and greets it if that is due. `payload` lives until the next
  /// call; `stamp_ns` is its arrival on CLOCK_MONOTONIC. Status: ok; empty; disconnected (closed).
  [[nodiscard]] Status receive(std::span<const std::uint8_t>& payload, rt::Nanoseconds& stamp_ns) noexcept;

  /// The peer was heard less than `silence_ns` before the last call of receive().
  [[nodiscard]] bool has_peer() const noexcept { return has_peer_; }
  [[nodiscard]] bool is_open() const noexcept { return descriptor_ >= 0; }
  [[nodiscard]] const DatagramLinkCounters& counters() const noexcept { return counters_; }

 private:
  enum class Kind : std::uint8_t { hello = 1, data = 2, bye = 3 };
  struct Head {
    Kind kind{};
    std::uint64_t from{};
    std::uint64_t to{};
    std::uint32_t number{};
  };

  Status put(Kind kind, std::uint64_t to, std::span<const std::uint8_t> payload) noexcept;
  void greet(rt::Nanoseconds now_ns) noexcept;
  bool read_head(std::span<const std::uint8_t> datagram, Head& head) noexcept;
  bool admit(const Head& head, std::uint16_t port, rt::Nanoseconds stamp_ns) noexcept;
  bool admit_peer(const Head& head, std::uint16_t port) noexcept;

  DatagramLinkConfig config_;
  int descriptor_{-1};
  bool has_peer_{};
  std::uint64_t peer_{};  ///< its session
  std::uint16_t peer_port_{};
  std::uint32_t peer_number_{};  ///< of its newest datagram
  rt::Nanoseconds heard_ns_{};   ///< when that came
  rt::Nanoseconds polled_ns_{};  ///< last look at the socket
  rt::Nanoseconds next_hello_ns_{};
  std::uint32_t number_{};  ///< of the next datagram
  std::uint32_t kernel_overruns_{};
  DatagramLinkCounters counters_{};
  std::array<std::uint8_t, kHeadBytes + kMaxPayload> out_{};
  std::array<std::uint8_t, kHeadBytes + kMaxPayload> in_{};
};

}  // namespace sortie::drivers
