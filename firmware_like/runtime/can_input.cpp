// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/can_input.hpp"

#include <string>

#include "drivers/channels.hpp"
#include "drivers/wire.hpp"

namespace sortie::firmware {

Status receive_can(const Devices& devices, rt::Nanoseconds now_ns, drivers::CanFrame& frame) {
  if (devices.can == nullptr) return Status::empty;
  const Status status = devices.can->receive(frame);
  if (status != Status::ok || devices.log == nullptr) return status;
  std::uint8_t message[drivers::kCanBytes];
  std::size_t size = 0;
  if (drivers::encode(frame, message, size) == Status::ok) {
    devices.log->sample(std::string(drivers::kChannelCan), now_ns, {message, size});
  }
  return status;
}

}  // namespace sortie::firmware
