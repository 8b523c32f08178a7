// SPDX-License-Identifier: BSD-3-Clause
// Where everything that is asked of a run comes in: over LCM, if the profile allows it, and from its script.
// Each kind of request has a desk behind this door (request_desk.hpp).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "drivers/lcm_receiver.hpp"
#include "drivers/wire_requests.hpp"
#include "firmware_like/link/request_desk.hpp"
#include "firmware_like/link/secret.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// One thread calls open() and poll(); any thread may read the rest. Not real-time.
class RequestDoor {
 public:
  explicit RequestDoor(Runtime& runtime)
      : runtime_(runtime),
        desks_(runtime, runtime.vehicle().fly_requests(), runtime.vehicle().drive_requests()) {}

  /// Listens to requests on an LCM address, if any desk wants them. Empty, or why not. Throws ProfileError
  /// when the secret cannot be used.
  std::string open(const std::string& url);

  /// Hands in what the script holds up to `now_ns` of the run's clock.
  void run_script(rt::Nanoseconds now_ns);
  /// The same, and takes the requests that have come in; at most 256 of each queue, without waiting. What has
  /// waited in the kernel's queue is judged by its age now.
  void poll(rt::Nanoseconds now_ns);

  /// What became of requests and of datagrams, by name. For the thread that polls, or after it.
  void add_counters(std::map<std::string, std::uint64_t>& out) const;
  RequestDesk<drivers::SetParameter>& parameters() { return std::get<0>(desks_); }
  const RequestDesk<drivers::SetParameter>& parameters() const { return std::get<0>(desks_); }
  /// Calls `use(message)` with what is answered to requests, once for each task that obeys any; the caller
  /// adds the date and that task's state. Session 0: none are taken, for want of a secret or a network.
  template <class Use>
  void for_each_answer(Use use) const {
    for_each_desk([&](const auto& desk) {
      drivers::AnswersMessage message;
      if constexpr (requires { desk.describe(message); }) {
        if (!desk.wanted()) return;
        message.session = session_;
        message.robot = robot_;
        message.keyed = key_.has_value();
        desk.describe(message);
        use(std::move(message));
      }
    });
  }
  /// Of the run; null where there is none.
  const drivers::SipKey* key() const { return key_ ? &*key_ : nullptr; }
  /// True when requests are listened to.
  bool listens() const { return receiver_ != nullptr; }
  /// What a run tells of its parameters, with the newest answers; the caller adds the date and what is in
  /// force.
  drivers::ParametersMessage describe() const;

 private:
  template <class Use>
  void for_each_desk(Use use) const {
    std::apply([&](const auto&... desk) { (use(desk), ...); }, desks_);
  }
  template <class Use>
  void for_each_desk(Use use) {
    std::apply([&](auto&... desk) { (use(desk), ...); }, desks_);
  }
  void drain(drivers::LcmReceiver& receiver, rt::Nanoseconds now_ns);

  Runtime& runtime_;
  std::size_t next_line_{};
  std::unique_ptr<drivers::LcmReceiver> receiver_;
  // A queue of its own in the kernel, of stops alone: whatever fills the other hides none. A stop comes by
  // both, and one that is taken twice stops as before. Null where the kernel has no filters.
  std::unique_ptr<drivers::LcmReceiver> stops_;
  std::optional<drivers::SipKey> key_;
  std::int64_t session_{};
  std::string robot_;
  std::tuple<RequestDesk<drivers::SetParameter>, RequestDesk<drivers::FlyRequestMessage>,
             RequestDesk<drivers::DriveRequestMessage>>
      desks_;
};

}  // namespace sortie::firmware
