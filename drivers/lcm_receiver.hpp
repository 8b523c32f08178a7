// SPDX-License-Identifier: BSD-3-Clause
// Listens to LCM multicast with bounded memory. liblcm 1.3.1 can be crashed by malformed fragments from the
// network, so nothing of ours subscribes with it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/datagram_filter.hpp"
#include "drivers/lcm_url.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// A whole message in one datagram; views of the datagram's bytes.
struct Lc02Message {
  std::uint32_t sequence{};
  std::string_view channel;  ///< 1 to 63 bytes, any value but zero
  std::span<const std::uint8_t> payload;
};

/// Takes an LCM datagram apart without trusting it. Form, big endian: u32 "LC02", u32 sequence, channel,
/// zero, payload. Status: ok; not_supported (a fragment, "LC03": messages above 64 kB are not put together,
/// because that needs memory that a stranger chooses); malformed (anything else). `message` changes only with
/// ok. Reads nothing outside the datagram; cost: linear in the channel's length.
[[nodiscard]] Status parse_lc02(std::span<const std::uint8_t> datagram, Lc02Message& message) noexcept;

/// What came in since start.
struct LcmReceiverCounters {
  std::uint64_t messages{};
  std::uint64_t bytes{};      ///< payload of the messages
  std::uint64_t fragments{};  ///< parts of messages above 64 kB, not put together
  std::uint64_t malformed{};  ///< not LCM, or cut
  std::uint64_t socket_errors{};
};

/// A received message; views live until the next call of receive().
struct ReceivedMessage {
  Lc02Message message;
  rt::Nanoseconds stamp_ns{};  ///< UTC, when the kernel took it (or receive() did, where it gives no stamp)
};

/// One thread uses it. No heap after construction; memory: 64 kB and the kernel's buffer.
class LcmReceiver {
 public:
  /// Joins the group. With rules the kernel puts only what fits to one of them into this socket's queue.
  /// Throws std::runtime_error (address, system's reason, cure), with rules also where the kernel has no
  /// filters.
  explicit LcmReceiver(const std::string& url, std::span<const FilterRule> any_of = {});
  ~LcmReceiver();
  LcmReceiver(const LcmReceiver&) = delete;
  LcmReceiver& operator=(const LcmReceiver&) = delete;

  /// Waits up to `timeout_ms` for a datagram and takes it. Status: ok; empty (nothing came); not_supported
  /// (fragment) and malformed (both counted, call again); disconnected (the socket failed, counted).
  [[nodiscard]] Status receive(ReceivedMessage& received, int timeout_ms) noexcept;
  [[nodiscard]] const LcmReceiverCounters& counters() const noexcept { return counters_; }

  static constexpr std::size_t kMaxDatagram = 65536;

 private:
  int fd_{-1};
  std::unique_ptr<std::uint8_t[]> buffer_;
  LcmReceiverCounters counters_{};
};

}  // namespace sortie::drivers
