// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/spy_requests.hpp"

#include "drivers/wire_answers.hpp"
#include "drivers/wire_fly.hpp"
#include "drivers/wire_requests.hpp"

namespace sortie::toolchain {

namespace {

template <class Number>
void add(std::vector<drivers::NamedValue>& values, const char* name, Number number) {
  values.push_back({name, static_cast<double>(number)});
}

}  // namespace

Status read_drive_request(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values) {
  drivers::DriveRequestMessage request;
  const Status status = drivers::decode(message, nullptr, request);
  add(values, "counter", request.counter);
  add(values, "speed_m_s", request.speed_m_s);
  add(values, "turn_rad_s", request.turn_rad_s);
  add(values, "mode", request.mode);
  add(values, "posture", request.posture);
  add(values, "flags", request.flags);
  return status;
}

Status read_fly_request(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values) {
  drivers::FlyRequestMessage request;
  const Status status = drivers::decode(message, nullptr, request);
  add(values, "counter", request.counter);
  add(values, "x_m", request.x_m);
  add(values, "y_m", request.y_m);
  add(values, "z_m", request.z_m);
  add(values, "yaw_rad", request.yaw_rad);
  add(values, "mode", request.mode);
  return status;
}

Status read_answers(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values) {
  drivers::AnswersMessage answers;
  const Status status = drivers::decode(message, nullptr, answers);
  add(values, "counter", answers.counter);
  add(values, "keyed", answers.keyed ? 1 : 0);
  for (drivers::NamedValue& value : answers.state) values.push_back(std::move(value));
  return status;
}

}  // namespace sortie::toolchain
