// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/commands/drive_client.hpp"

#include <algorithm>
#include <stdexcept>

#include "drivers/wire_telemetry.hpp"
#include "firmware_like/commands/parameter_client.hpp"
#include "firmware_like/secret.hpp"

namespace sortie::firmware {

namespace {

using Clock = std::chrono::steady_clock;

// What the drive's fields say; false for another task's.
bool read_state(std::span<const std::uint8_t> message, DriveState& state) {
  drivers::FieldsMessage fields;
  if (drivers::decode(message, fields) != Status::ok || fields.task != "drive") return false;
  for (const drivers::NamedValue& field : fields.values) {
    if (field.name == "request_counter") state.request_counter = static_cast<std::int64_t>(field.value);
    if (field.name == "source") state.source = static_cast<std::uint32_t>(field.value);
    if (field.name == "stop") state.stop = static_cast<std::uint32_t>(field.value);
    if (field.name == "speed_m_s") state.speed_m_s = field.value;
    if (field.name == "turn_rad_s") state.turn_rad_s = field.value;
  }
  return true;
}

}  // namespace

DriveClient::DriveClient(const std::string& url, std::optional<drivers::SipKey> key, std::int64_t session)
    : receiver_(url),
      publisher_(request_publisher(url)),
      key_(key),
      session_(session),
      sender_(unguessable_number()) {
  if (!publisher_.active()) throw std::runtime_error(publisher_.problem());
}

bool DriveClient::listen(std::chrono::milliseconds most) {
  const std::string channel = std::string(drivers::kChannelFields) + "_drive";
  const auto end = Clock::now() + most;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left < 0) return false;
    drivers::ReceivedMessage received;
    const auto wait = static_cast<int>(std::min<std::int64_t>(left + 1, 100));
    if (receiver_.receive(received, wait) != Status::ok || received.message.channel != channel) continue;
    if (read_state(received.message.payload, state_)) return true;
  }
}

std::int64_t DriveClient::ask(drivers::DriveRequestMessage request) {
  counter_ = std::max(counter_, state_.request_counter) + 1;
  request.utime = utc_us();
  request.session = session_;
  request.sender = sender_;
  request.counter = counter_;
  // What the network does not take is asked for again: whoever is in control repeats itself.
  static_cast<void>(
      publisher_.publish_encoded(drivers::kChannelDrive, [&](std::span<std::uint8_t> out, std::size_t& size) {
        return drivers::encode(request, key_ ? &*key_ : nullptr, out, size);
      }));
  ++sent_;
  return counter_;
}

}  // namespace sortie::firmware
