// SPDX-License-Identifier: BSD-3-Clause
// SocketCAN: sending, receiving, kernel stamps, error frames. Opening is in can_socket_open.cpp.
#include "drivers/can_socket.hpp"

#include "drivers/can_timing.hpp"

#if defined(__linux__)
#include <linux/can.h>

#include <cstring>
#endif

namespace sortie::drivers {

#if defined(__linux__)

namespace {

can_frame to_kernel(const CanFrame& frame) {
  can_frame k{};
  k.can_id = frame.id;
  if ((frame.flags & kCanExtended) != 0) k.can_id |= CAN_EFF_FLAG;
  if ((frame.flags & kCanRemote) != 0) k.can_id |= CAN_RTR_FLAG;
  k.can_dlc = frame.size;
  std::memcpy(k.data, frame.data, sizeof k.data);
  return k;
}

CanFrame from_kernel(const can_frame& k) {
  CanFrame frame;
  if ((k.can_id & CAN_ERR_FLAG) != 0) {
    frame.flags = kCanError;
    frame.id = k.can_id & CAN_ERR_MASK;
  } else {
    const bool extended = (k.can_id & CAN_EFF_FLAG) != 0;
    const bool remote = (k.can_id & CAN_RTR_FLAG) != 0;
    if (extended) frame.flags = kCanExtended;
    if (remote) frame.flags = static_cast<std::uint8_t>(frame.flags | kCanRemote);
    frame.id = k.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  }
  frame.size = k.can_dlc <= 8 ? k.can_dlc : std::uint8_t{8};
  if ((frame.flags & kCanRemote) == 0) std::memcpy(frame.data, k.data, frame.size);
  return frame;
}

}  // namespace

Status SocketCan::send(const CanFrame& frame) noexcept {
  if (!can_frame_valid(frame)) return Status::malformed;
  const can_frame k = to_kernel(frame);
  return path_.send(&k, sizeof k);
}

Status SocketCan::receive(CanFrame& frame) noexcept {
  can_frame k{};
  std::size_t bytes = 0;
  rt::Nanoseconds stamp_ns = 0;
  const Status status = path_.receive(&k, sizeof k, bytes, stamp_ns);
  if (status != Status::ok) return status;
  if (bytes != sizeof k) return Status::malformed;
  frame = from_kernel(k);
  frame.stamp_ns = stamp_ns;
  if ((frame.flags & kCanError) != 0) {
    path_.note_error(frame.id, frame.data[1]);
  } else {
    path_.note_frame();
  }
  return Status::ok;
}

#else

Status SocketCan::send(const CanFrame&) noexcept { return Status::not_supported; }
Status SocketCan::receive(CanFrame&) noexcept { return Status::not_supported; }

#endif

}  // namespace sortie::drivers
