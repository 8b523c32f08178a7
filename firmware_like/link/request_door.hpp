// SPDX-License-Identifier: BSD-3-Clause
// Where changes of run-time parameters are asked for: the profile's script and, if the profile allows it,
// requests over LCM; requests to drive and to fly come by the same door. A refusal happens here, before
// anything is recorded, and is counted by its reason.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_answers.hpp"
#include "drivers/wire_parameters.hpp"
#include "firmware_like/link/request_desk.hpp"
#include "firmware_like/link/secret.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// What became of the changes that were asked for.
struct RequestDoorCounters {
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
class RequestDoor {
 public:
  explicit RequestDoor(Runtime& runtime)
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
  /// The same, and takes the requests that have come in; at most 256 of each queue, without waiting. What has
  /// waited in the kernel's queue is judged by its age now.
  void poll(rt::Nanoseconds now_ns);

  RequestDoorCounters counters() const;
  /// Requests to drive and to fly, which come in by the same door.
  const RequestDesk<drivers::DriveRequestMessage>& drive() const { return drive_; }
  const RequestDesk<drivers::FlyRequestMessage>& fly() const { return fly_; }
  /// Calls `use(message)` with what is answered to requests, once for each task that obeys any; the caller
  /// adds the date and that task's state. Session 0 says that none are taken, for want of a secret or of a
  /// network.
  template <class Use>
  void for_each_answer(Use use) const {
    const auto one = [&](const auto& desk) {
      if (!desk.wanted()) return;
      drivers::AnswersMessage message;
      message.session = session_;
      message.robot = robot_;
      message.keyed = key_.has_value();
      desk.describe(message);
      use(std::move(message));
    };
    one(drive_);
    one(fly_);
  }
  /// Of the run; null where there is none.
  const drivers::SipKey* key() const { return key_ ? &*key_ : nullptr; }
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

  void drain(drivers::LcmReceiver& receiver, rt::Nanoseconds now_ns);
  void take(std::span<const std::uint8_t> message, rt::Nanoseconds now_ns, const RequestAge& age);

  Runtime& runtime_;
  std::size_t next_line_{};
  std::unique_ptr<drivers::LcmReceiver> receiver_;
  // A queue of its own in the kernel, of stops alone: whatever fills the other hides none. A stop comes by
  // both, and one that is taken twice stops as before. Null where the kernel has no filters.
  std::unique_ptr<drivers::LcmReceiver> stops_;
  std::optional<drivers::SipKey> key_;
  std::int64_t session_{};
  std::string robot_;
  RequestDesk<drivers::DriveRequestMessage> drive_;
  RequestDesk<drivers::FlyRequestMessage> fly_;

  mutable std::mutex mutex_;  // of all below
  RequestDoorCounters counters_;
  std::int64_t newest_{};
  std::uint64_t version_{};
  std::vector<drivers::ParameterAnswer> answers_;
};

}  // namespace sortie::firmware
