// SPDX-License-Identifier: BSD-3-Clause
// SocketCAN: sending, receiving, kernel stamps, error frames. Opening is in can_socket_open.cpp.
#include "drivers/can_socket.hpp"

#include "drivers/can_socket_open.hpp"
#include "drivers/can_timing.hpp"

#if defined(__linux__)
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#endif

namespace sortie::drivers {

SocketCan::~SocketCan() { close(); }

void SocketCan::adopt(int descriptor, rt::Nanoseconds epoch_ns) {
  close();
  descriptor_ = descriptor;
  epoch_ns_ = epoch_ns;
  bus_off_ = false;
  kernel_overruns_ = 0;
  counters_ = {};
}

void SocketCan::note_overruns(std::uint32_t kernel_total) noexcept {
  counters_.rx_overrun += static_cast<std::uint32_t>(kernel_total - kernel_overruns_);  // the total wraps
  kernel_overruns_ = kernel_total;
}

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

void SocketCan::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

void SocketCan::note_error_frame(const CanFrame& frame) noexcept {
  ++counters_.error_frames;
  if ((frame.id & CAN_ERR_BUSOFF) != 0) bus_off_ = true;
  if ((frame.id & CAN_ERR_RESTARTED) != 0) bus_off_ = false;
}

Status SocketCan::send(const CanFrame& frame) noexcept {
  if (!can_frame_valid(frame)) return Status::malformed;
  if (descriptor_ < 0 || bus_off_) return Status::disconnected;
  const can_frame k = to_kernel(frame);
  if (::send(descriptor_, &k, sizeof k, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof k)) {
    ++counters_.sent;
    return Status::ok;
  }
  const Status status = meaning_of_can_error(errno, Status::full);
  if (status == Status::full) ++counters_.tx_refused;
  return status;
}

Status SocketCan::receive(CanFrame& frame) noexcept {
  if (descriptor_ < 0) return Status::disconnected;
  can_frame k{};
  const CanPacket packet = take_can_packet(descriptor_, &k, sizeof k);
  if (packet.status != Status::ok) return packet.status;
  if (packet.bytes != sizeof k) return Status::malformed;
  const KernelNote& note = packet.note;
  if (note.counts_overruns) note_overruns(note.overruns);
  frame = from_kernel(k);
  frame.stamp_ns = note.stamp_ns - epoch_ns_;
  if ((frame.flags & kCanError) != 0) {
    note_error_frame(frame);
  } else {
    ++counters_.received;
  }
  return Status::ok;
}

#else

void SocketCan::close() noexcept { descriptor_ = -1; }
void SocketCan::note_error_frame(const CanFrame&) noexcept {}
Status SocketCan::send(const CanFrame&) noexcept { return Status::not_supported; }
Status SocketCan::receive(CanFrame&) noexcept { return Status::not_supported; }

#endif

}  // namespace sortie::drivers
