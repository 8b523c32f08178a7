// SPDX-License-Identifier: BSD-3-Clause
// Where changes of run-time parameters are asked for: the profile's script and, if the profile allows it,
// requests over LCM; requests to the drive come by the same door. A refusal happens here, before anything is
// recorded, and is counted by its reason.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_parameters.hpp"
#include "firmware_like/drive_desk.hpp"
#include "firmware_like/fly_desk.hpp"
#include "firmware_like/runtime.hpp"
#include "firmware_like/secret.hpp"

namespace sortie::firmware {

/// What became of the changes that were asked for.
struct ParameterDeskCounters {
  std::uint64_t admitted{};
  std::uint64_t unknown{};
  std::uint64_t not_finite{};
  std::uint64_t out_of_range{};
  std::uint64_t full{};           ///< more changes at once than a group takes
  std::uint64_t malformed{};      ///< no request, or a damaged one
  std::uint64_t bad_tag{};        ///< from somebody who does not know the secret
  std::uint64_t wrong_session{};  ///< meant for another run
  std::uint64_t wrong_time{};     ///< held back, or of a clock that is far from the run's
  std::uint64_t stale{};          ///< repeated, or overtaken by a later one
  SORTIE_FIELDS(admitted, unknown, not_finite, out_of_range, full, malformed, bad_tag, wrong_session,
                wrong_time, stale)
};

/// One thread calls set() and poll(); any thread may read the rest. Not real-time.
class ParameterDesk {
 public:
  explicit ParameterDesk(Runtime& runtime)
      : runtime_(runtime),
        drive_(runtime.vehicle().drive_requests()),
        fly_(runtime.vehicle().fly_requests()) {}

  /// Listens to requests on an LCM address, if [parameters] remote or the vehicle's drive or pilot wants
  /// them. Empty, or why not. Throws ProfileError when the secret cannot be used.
  std::string open(const std::string& url);

  /// Hands in one change. Status: ok (it is in the log and will be applied by the group's next job),
  /// not_supported (no such parameter), not_finite, out_of_range, full. All counted.
  Status set(std::string_view name, double value, rt::Nanoseconds now_ns);

  /// Hands in what the script holds up to `now_ns` of the run's clock.
  void run_script(rt::Nanoseconds now_ns);
  /// The same, and takes the requests that have come in; at most 64 of them, without waiting.
  void poll(rt::Nanoseconds now_ns);

  ParameterDeskCounters counters() const;
  /// Requests to the drive, which come in by the same door.
  const DriveDesk& drive() const { return drive_; }
  const FlyDesk& fly() const { return fly_; }
  /// What came in by the network; null where nothing is listened to. For the thread that polls, or after it.
  const drivers::LcmReceiverCounters* network() const {
    return receiver_ == nullptr ? nullptr : &receiver_->counters();
  }
  /// Every parameter with its first value, and the newest answers; the caller fills in what is in force.
  drivers::ParametersMessage describe() const;
  /// Changes whenever describe() does.
  std::uint64_t version() const;

 private:
  static constexpr std::size_t kAnswers = 16;

  void take(std::span<const std::uint8_t> message, rt::Nanoseconds now_ns, const RequestAge& age);

  Runtime& runtime_;
  std::size_t next_line_{};
  std::unique_ptr<drivers::LcmReceiver> receiver_;
  std::optional<drivers::SipKey> key_;
  std::int64_t session_{};
  DriveDesk drive_;
  FlyDesk fly_;

  mutable std::mutex mutex_;  // of all below
  ParameterDeskCounters counters_;
  std::int64_t newest_{};
  std::uint64_t version_{};
  std::vector<drivers::ParameterAnswer> answers_;
};

}  // namespace sortie::firmware
