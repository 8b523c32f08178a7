// SPDX-License-Identifier: BSD-3-Clause
// SocketCAN: classical frames in the kernel's form, and back.
#include "drivers/can_socket.hpp"

#include <linux/can.h>

#include <cstring>

#include "drivers/can_timing.hpp"

namespace sortie::drivers {

Status SocketCan::send(const CanFrame& frame) noexcept {
  if (!can_frame_valid(frame)) return Status::malformed;
  can_frame k{};
  k.can_id = to_kernel_id(frame.id, frame.flags);
  k.can_dlc = frame.size;
  std::memcpy(k.data, frame.data, sizeof k.data);
  return path_.send(&k, sizeof k);
}

Status SocketCan::receive(CanFrame& frame) noexcept {
  can_frame k{};
  std::size_t bytes = 0;
  rt::Nanoseconds stamp_ns = 0;
  const Status status = path_.receive(&k, sizeof k, bytes, stamp_ns);
  if (status != Status::ok) return status;
  if (bytes != sizeof k) return Status::malformed;
  frame = {};
  frame.stamp_ns = stamp_ns;
  frame.id = from_kernel_id(k.can_id, frame.flags);
  frame.size = k.can_dlc <= 8 ? k.can_dlc : std::uint8_t{8};
  if ((frame.flags & kCanRemote) == 0) std::memcpy(frame.data, k.data, frame.size);
  path_.note(frame.flags, frame.id, frame.data[1]);
  return Status::ok;
}

}  // namespace sortie::drivers
