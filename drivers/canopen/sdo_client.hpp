// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes one object of one node at a time, with a time-out and repeats (CiA 301, expedited SDO).
#pragma once

#include <cstdint>

#include "drivers/canopen/frames.hpp"
#include "rt/time.hpp"

namespace sortie::drivers::canopen {

/// How far a transfer has come.
enum class SdoProgress : std::uint8_t { idle, waiting, done, aborted, timed_out };

/// Where a transfer ended, or that it has not.
struct SdoResult {
  SdoProgress progress{};
  std::uint32_t value{};  ///< of a read; of an abort, its code
};

/// One client. No heap, no clock of its own; 40 bytes.
class SdoClient {
 public:
  static constexpr rt::Nanoseconds kTimeoutNs = 100 * rt::kNanosecondsPerMillisecond;  ///< of one attempt
  static constexpr std::uint32_t kAttempts = 3;

  explicit SdoClient(std::uint8_t node) : node_(node) {}

  /// Begins a transfer; one under way is forgotten (its late answer names another object, or repeats a
  /// value).
  void read(ObjectKey key) noexcept { begin({SdoKind::read, key, 0, 0}); }
  void write(ObjectKey key, std::uint32_t value, std::uint8_t bytes) noexcept {
    begin({SdoKind::write, key, value, bytes});
  }

  /// What should be sent now: the request, its repeat after a time-out. True: `frame` is set. Call sent()
  /// when it went out; otherwise it is offered again.
  bool poll(rt::Nanoseconds now_ns, CanFrame& frame) noexcept;
  void sent(rt::Nanoseconds now_ns) noexcept;

  /// Takes a reply of this node. False: it answers nothing that was asked (a late or wrong answer).
  bool take(const Sdo& reply) noexcept;

  const SdoResult& result() const noexcept { return result_; }

 private:
  void begin(const Sdo& request) noexcept;

  Sdo request_{};
  SdoResult result_{};
  rt::Nanoseconds sent_ns_{};
  std::uint32_t attempts_{};
  std::uint8_t node_;
  bool offered_{};  // the request waits for being sent
};

}  // namespace sortie::drivers::canopen
