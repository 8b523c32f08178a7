// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_fd.hpp"

#include <algorithm>

#if defined(__linux__)
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
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

void CanFdSocket::adopt(int descriptor, rt::Nanoseconds epoch_ns) {
  close();
  descriptor_ = descriptor;
  epoch_ns_ = epoch_ns;
  bus_off_ = false;
  kernel_overruns_ = 0;
  counters_ = {};
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
  if (status == Status::ok) adopt(descriptor, config.epoch_ns);
  return status;
}

void CanFdSocket::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

Status CanFdSocket::send(const CanFdFrame& frame) noexcept {
  if (!can_fd_frame_valid(frame)) return Status::malformed;
  if (descriptor_ < 0 || bus_off_) return Status::disconnected;
  const canfd_frame k = to_kernel(frame);
  // The beginning of an FD frame is a classical one: the length of the packet tells the kernel which it is.
  const std::size_t size = (frame.flags & kCanFd) != 0 ? CANFD_MTU : CAN_MTU;
  if (::send(descriptor_, &k, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size)) {
    ++counters_.sent;
    return Status::ok;
  }
  const Status status = meaning_of_can_error(errno, Status::full);
  if (status == Status::full) ++counters_.tx_refused;
  return status;
}

Status CanFdSocket::receive(CanFdFrame& frame) noexcept {
  if (descriptor_ < 0) return Status::disconnected;
  canfd_frame k{};
  const CanPacket packet = take_can_packet(descriptor_, &k, sizeof k);
  if (packet.status != Status::ok) return packet.status;
  const bool is_fd = packet.bytes == CANFD_MTU;
  if ((!is_fd && packet.bytes != CAN_MTU) || k.len > (is_fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN))
    return Status::malformed;
  const KernelNote& note = packet.note;
  if (note.counts_overruns) {
    counters_.rx_overrun += static_cast<std::uint32_t>(note.overruns - kernel_overruns_);  // the total wraps
    kernel_overruns_ = note.overruns;
  }
  frame = from_kernel(k, is_fd);
  frame.stamp_ns = note.stamp_ns - epoch_ns_;
  if ((frame.flags & kCanError) == 0) {
    ++counters_.received;
    return Status::ok;
  }
  ++counters_.error_frames;
  if ((frame.id & CAN_ERR_BUSOFF) != 0) bus_off_ = true;
  if ((frame.id & CAN_ERR_RESTARTED) != 0) bus_off_ = false;
  return Status::ok;
}

#else

Status CanFdSocket::open(const SocketCanConfig&, std::string& problem) {
  problem = "SocketCAN: only Linux has it; run against the simulated bus";
  return Status::not_supported;
}
void CanFdSocket::close() noexcept { descriptor_ = -1; }
Status CanFdSocket::send(const CanFdFrame&) noexcept { return Status::not_supported; }
Status CanFdSocket::receive(CanFdFrame&) noexcept { return Status::not_supported; }

#endif

}  // namespace sortie::drivers
