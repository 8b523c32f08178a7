// SPDX-License-Identifier: BSD-3-Clause
// Listens to LCM multicast with bounded memory. liblcm 1.3.1 can be crashed by malformed fragments from the
// network, so nothing of ours subscribes with it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/datagram_filter.hpp"
#include "drivers/lc02.hpp"
#include "drivers/lcm_url.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

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
  rt::Nanoseconds
      stamp_ns{};  ///< UTC, when the kernel took the datagram (or receive() did, where it gives no stamp)
};

/// One thread uses it. No heap after construction; memory: 64 kB and the kernel's buffer.
class LcmReceiver {
 public:
  /// Joins the group. Throws std::runtime_error (address, system's reason, cure).
  explicit LcmReceiver(const std::string& url);
  /// The same, and the kernel puts only what fits to one of the rules into this socket's queue. Throws also
  /// where the kernel has no filters.
  LcmReceiver(const std::string& url, std::span<const FilterRule> any_of);
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
