// SPDX-License-Identifier: BSD-3-Clause
// Telemetry out: messages go into a ring of fixed slots, and a thread of its own hands them to LCM. The
// caller is never blocked; what does not fit is dropped and counted.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/lcm_url.hpp"
#include "rt/spsc_ring.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// How much the publisher may hold back, and where it sends.
struct LcmPublisherConfig {
  std::string url{kDefaultLcmUrl};  ///< udpm:// or file://; "none": off. LCM_DEFAULT_URL is not looked at.
  std::uint32_t slots{256};         ///< messages that may wait; rounded up to a power of two
  std::size_t slot_bytes{4096};     ///< longest message
};

/// What became of the messages since start.
struct LcmPublisherCounters {
  std::uint64_t published{};    ///< handed to the network
  std::uint64_t dropped{};      ///< the ring was full: the newest was dropped
  std::uint64_t refused{};      ///< too long for a slot, bad channel name, or not encodable
  std::uint64_t send_errors{};  ///< the network did not take it
};

/// One thread may call publish(); any thread may read the counters. Memory: slots * (slot_bytes + 80) bytes,
/// taken by the constructor.
class LcmPublisher {
 public:
  /// Opens the network and starts the thread. If that fails the publisher is off and problem() says why in
  /// one line: a run goes on without telemetry.
  explicit LcmPublisher(const LcmPublisherConfig& config = {});
  /// Sends what waits and ends the thread.
  ~LcmPublisher();
  LcmPublisher(const LcmPublisher&) = delete;
  LcmPublisher& operator=(const LcmPublisher&) = delete;

  [[nodiscard]] bool active() const noexcept { return active_; }
  /// Empty, or why the publisher is off although it was asked for.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

  /// Queues a copy of an encoded message. Wait-free, no heap, no system call. Status: ok; full (dropped);
  /// out_of_range (longer than a slot); malformed (channel name empty or beyond 63 bytes); disconnected
  /// (off).
  [[nodiscard]] Status publish(std::string_view channel, std::span<const std::uint8_t> message) noexcept;

  /// The same, but `encode(span, size&) -> Status` writes straight into the slot. Its error is passed on and
  /// counted as refused.
  template <class Encode>
  requires requires(Encode& encode, std::span<std::uint8_t> out, std::size_t& size) { encode(out, size); }
  [[nodiscard]] Status publish_encoded(std::string_view channel, Encode&& encode) noexcept {
    std::span<std::uint8_t> slot;
    if (const Status status = reserve(channel, slot); status != Status::ok) return status;
    std::size_t size = 0;
    const Status encoded = encode(slot, size);
    return commit(channel, encoded, size);
  }

  [[nodiscard]] LcmPublisherCounters counters() const noexcept;
  /// Processor time of the sending thread up to its newest round [ns]. Any thread.
  [[nodiscard]] std::int64_t cpu_ns() const noexcept { return cpu_ns_.load(std::memory_order_relaxed); }
  /// Memory of a publisher that is on; what liblcm takes for itself is not in it.
  [[nodiscard]] static std::size_t bytes_for(const LcmPublisherConfig& config) noexcept {
    const std::size_t slot = config.slot_bytes + sizeof(std::uint32_t) + sizeof(Ready);
    return sizeof(LcmPublisher) + std::bit_ceil(config.slots) * slot;
  }

 private:
  struct Ready {
    std::uint32_t slot{};
    std::uint32_t size{};
    char channel[kMaxChannelLength + 1]{};
  };
  struct Network;

  Status reserve(std::string_view channel, std::span<std::uint8_t>& slot) noexcept;
  Status commit(std::string_view channel, Status encoded, std::size_t size) noexcept;
  void send_waiting() noexcept;

  // Written by the caller's thread only, or by the sending thread only; read by anybody.
  struct Count {
    std::atomic<std::uint32_t> value{0};
    void add() noexcept { value.store(value.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }
  };

  LcmPublisherConfig config_;
  std::string problem_;
  bool active_{};
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::unique_ptr<std::uint32_t[]> free_slots_;
  std::unique_ptr<Ready[]> ready_slots_;
  rt::SpscSpanRing<std::uint32_t> free_;  // sender -> caller: slots that may be written
  rt::SpscSpanRing<Ready> ready_;         // caller -> sender: messages that wait
  bool have_reserved_{};
  std::uint32_t reserved_{};
  std::atomic<std::int64_t> cpu_ns_{0};
  Count published_, dropped_, refused_, send_errors_;
  std::unique_ptr<Network> network_;
};

}  // namespace sortie::drivers
