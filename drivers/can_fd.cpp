// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_fd.hpp"

#include <algorithm>

#if defined(__linux__)
#include <linux/can.h>

#include <cstring>

#include "drivers/can_socket_open.hpp"
#endif

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

#if defined(__linux__)

namespace {

canfd_frame to_kernel(const CanFdFrame& frame) {
  canfd_frame k{};
  k.can_id = frame.id;
  if ((frame.flags & kCanExtended) != 0) k.can_id |= CAN_EFF_FLAG;
  if ((frame.flags & kCanRemote) != 0) k.can_id |= CAN_RTR_FLAG;
  k.len = frame.size;
  if ((frame.flags & kCanBitRateSwitch) != 0) k.flags |= CANFD_BRS;
  if ((frame.flags & kCanErrorState) != 0) k.flags |= CANFD_ESI;
  if ((frame.flags & kCanRemote) == 0) std::memcpy(k.data, frame.data, frame.size);
  return k;
}

// `k.len` is at most what the kind allows.
CanFdFrame from_kernel(const canfd_frame& k, bool is_fd) {
  CanFdFrame frame;
  std::uint32_t flags = 0;
  if ((k.can_id & CAN_ERR_FLAG) != 0) {
    flags = kCanError;
    frame.id = k.can_id & CAN_ERR_MASK;
  } else {
    const bool extended = (k.can_id & CAN_EFF_FLAG) != 0;
    if (extended) flags |= kCanExtended;
    if ((k.can_id & CAN_RTR_FLAG) != 0) flags |= kCanRemote;
    frame.id = k.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  }
  if (is_fd) {
    flags |= kCanFd;
    if ((k.flags & CANFD_BRS) != 0) flags |= kCanBitRateSwitch;
    if ((k.flags & CANFD_ESI) != 0) flags |= kCanErrorState;
  }
  frame.flags = static_cast<std::uint8_t>(flags);
  frame.size = k.len;
  if ((flags & kCanRemote) == 0) std::memcpy(frame.data, k.data, frame.size);
  return frame;
}

}  // namespace

Status CanFdSocket::open(const SocketCanConfig& config, std::string& problem) {
  close();
  int descriptor = -1;
  const Status status = open_can_socket(config, CanSocketKind::fd, descriptor, problem);
  if (status != Status::ok) return status;
  config_ = config;
  const auto again = [](void* self) {
    return reopen_can_socket(static_cast<CanFdSocket*>(self)->config_, CanSocketKind::fd);
  };
  path_.use(descriptor, config.epoch_ns, again, this);
  return Status::ok;
}

Status CanFdSocket::send(const CanFdFrame& frame) noexcept {
  if (!can_fd_frame_valid(frame)) return Status::malformed;
  const canfd_frame k = to_kernel(frame);
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
  frame = from_kernel(k, is_fd);
  frame.stamp_ns = stamp_ns;
  if ((frame.flags & kCanError) != 0) {
    path_.note_error(frame.id, frame.data[1]);
  } else {
    path_.note_frame();
  }
  return Status::ok;
}

#else

Status CanFdSocket::open(const SocketCanConfig&, std::string& problem) {
  problem = "SocketCAN: only Linux has it; run against the simulated bus";
  return Status::not_supported;
}
Status CanFdSocket::send(const CanFdFrame&) noexcept { return Status::not_supported; }
Status CanFdSocket::receive(CanFdFrame&) noexcept { return Status::not_supported; }

#endif

}  // namespace sortie::drivers
