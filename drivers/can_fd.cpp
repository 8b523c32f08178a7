// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_fd.hpp"

#include <linux/can.h>

#include <algorithm>
#include <cstring>

namespace sortie::drivers {

bool can_fd_frame_valid(const CanFdFrame& frame) noexcept {
  const bool is_fd = (frame.flags & kCanFd) != 0;
  const unsigned fd_flags = kCanFd | kCanBitRateSwitch | kCanErrorState;
  const unsigned allowed = is_fd ? fd_flags | unsigned{kCanExtended} : unsigned{kCanExtended | kCanRemote};
  if ((frame.flags & ~allowed) != 0) return false;
  if (frame.id > ((frame.flags & kCanExtended) != 0 ? 0x1FFFFFFFu : 0x7FFu)) return false;
  return is_fd ? frame.size <= 64 && can_fd_size(frame.size) == frame.size : frame.size <= 8;
}

CanFdFrame widened(const CanFrame& frame) noexcept {
  CanFdFrame wide;
  wide.stamp_ns = frame.stamp_ns;
  wide.id = frame.id;
  wide.size = frame.size;
  wide.flags = frame.flags;
  std::copy_n(frame.data, sizeof frame.data, wide.data);
  return wide;
}

Status narrowed(const CanFdFrame& frame, CanFrame& out) noexcept {
  if ((frame.flags & kCanFd) != 0 || frame.size > 8) return Status::not_supported;
  out.stamp_ns = frame.stamp_ns;
  out.id = frame.id;
  out.size = frame.size;
  out.flags = frame.flags;
  std::copy_n(frame.data, sizeof out.data, out.data);
  return Status::ok;
}

Status CanFdSocket::send(const CanFdFrame& frame) noexcept {
  if (!can_fd_frame_valid(frame)) return Status::malformed;
  canfd_frame k{};
  k.can_id = to_kernel_id(frame.id, frame.flags);
  k.len = frame.size;
  if ((frame.flags & kCanBitRateSwitch) != 0) k.flags |= CANFD_BRS;
  if ((frame.flags & kCanErrorState) != 0) k.flags |= CANFD_ESI;
  if ((frame.flags & kCanRemote) == 0) std::memcpy(k.data, frame.data, frame.size);
  // The beginning of an FD frame is a classical one: the length of the packet tells the kernel which it is.
  return path_.send(&k, (frame.flags & kCanFd) != 0 ? CANFD_MTU : CAN_MTU);
}

Status CanFdSocket::receive(CanFdFrame& frame) noexcept {
  canfd_frame k{};
  std::size_t bytes = 0;
  rt::Nanoseconds stamp_ns = 0;
  const Status status = path_.receive(&k, sizeof k, bytes, stamp_ns);
  if (status != Status::ok) return status;
  const bool is_fd = bytes == CANFD_MTU;
  if ((!is_fd && bytes != CAN_MTU) || k.len > (is_fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN))
    return Status::malformed;
  frame = {};
  frame.stamp_ns = stamp_ns;
  frame.id = from_kernel_id(k.can_id, frame.flags);
  if (is_fd) {
    const unsigned more = kCanFd | ((k.flags & CANFD_BRS) != 0 ? unsigned{kCanBitRateSwitch} : 0u) |
                          ((k.flags & CANFD_ESI) != 0 ? unsigned{kCanErrorState} : 0u);
    frame.flags = static_cast<std::uint8_t>(frame.flags | more);
  }
  frame.size = k.len;
  if ((frame.flags & kCanRemote) == 0) std::memcpy(frame.data, k.data, frame.size);
  path_.note(frame.flags, frame.id, frame.data[1]);
  return Status::ok;
}

}  // namespace sortie::drivers
