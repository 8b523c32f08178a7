// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/commands/fly_client.hpp"

#include <algorithm>
#include <stdexcept>

#include "drivers/wire_telemetry.hpp"
#include "firmware_like/commands/parameter_client.hpp"
#include "firmware_like/secret.hpp"

namespace sortie::firmware {

namespace {

// What the pilot's fields say; false for another task's.
bool read_pilot(std::span<const std::uint8_t> message, FlyState& state) {
  drivers::FieldsMessage fields;
  if (drivers::decode(message, fields) != Status::ok || fields.task != "pilot") return false;
  for (const drivers::NamedValue& field : fields.values) {
    if (field.name == "request_counter") state.request_counter = static_cast<std::int64_t>(field.value);
    if (field.name == "step") state.step = static_cast<std::uint32_t>(field.value);
    if (field.name == "remote") state.remote = field.value != 0.0;
    if (field.name == "reached") state.reached = static_cast<std::uint32_t>(field.value);
    for (std::size_t i = 0; i < 3; ++i) {
      if (field.name == "setpoint_m[" + std::to_string(i) + "]") state.setpoint_m[i] = field.value;
    }
    if (field.name == "error_m") state.error_m = field.value;
  }
  return true;
}

}  // namespace

FlyClient::FlyClient(const std::string& url, std::optional<drivers::SipKey> key, std::int64_t session)
    : receiver_(url),
      publisher_(request_publisher(url)),
      key_(key),
      session_(session),
      sender_(unguessable_number()) {
  if (!publisher_.active()) throw std::runtime_error(publisher_.problem());
}

bool FlyClient::listen(std::chrono::milliseconds most) {
  using std::chrono::milliseconds;
  const std::string channel = std::string(drivers::kChannelFields) + "_pilot";
  const auto end = std::chrono::steady_clock::now() + most;
  while (true) {
    const auto left =
        std::chrono::duration_cast<milliseconds>(end - std::chrono::steady_clock::now()).count();
    if (left < 0) return false;
    drivers::ReceivedMessage received;
    const auto wait = static_cast<int>(std::min<std::int64_t>(left + 1, 100));
    if (receiver_.receive(received, wait) != Status::ok || received.message.channel != channel) continue;
    if (read_pilot(received.message.payload, state_)) return true;
  }
}

std::int64_t FlyClient::ask(drivers::FlyRequestMessage request) {
  counter_ = std::max(counter_, state_.request_counter) + 1;
  request.utime = utc_us();
  request.session = session_;
  request.sender = sender_;
  request.counter = counter_;
  // What the network does not take is asked for again.
  static_cast<void>(
      publisher_.publish_encoded(drivers::kChannelFly, [&](std::span<std::uint8_t> out, std::size_t& size) {
        return drivers::encode(request, key_ ? &*key_ : nullptr, out, size);
      }));
  ++sent_;
  return counter_;
}

}  // namespace sortie::firmware
