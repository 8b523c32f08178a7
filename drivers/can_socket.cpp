// SPDX-License-Identifier: BSD-3-Clause
// SocketCAN: the way that ports of both kinds share, and the port of classical frames.
#include "drivers/can_socket.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/can_timing.hpp"
#include "drivers/kernel_stamp.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::drivers {

namespace {

constexpr rt::Nanoseconds kProbeEvery = 100 * rt::kNanosecondsPerMillisecond;
constexpr rt::Nanoseconds kReopenEvery = 250 * rt::kNanosecondsPerMillisecond;

// Errors that no waiting ends: the interface was taken away, or the other end of a local socket.
bool means_gone(int error) {
  return error == ENODEV || error == ENXIO || error == EBADF || error == EPIPE || error == ECONNRESET ||
         error == ENOTCONN;
}

Status meaning_of(int error, Status when_busy) {
  switch (error) {
    case EAGAIN:
    case ENOBUFS:  // the interface's transmit queue is full
    case EINTR:
      return when_busy;
    case EINVAL:
    case EMSGSIZE:
      return Status::malformed;
    default:
      return Status::disconnected;
  }
}

}  // namespace

std::uint32_t to_kernel_id(std::uint32_t id, std::uint8_t flags) noexcept {
  if ((flags & kCanExtended) != 0) id |= CAN_EFF_FLAG;
  if ((flags & kCanRemote) != 0) id |= CAN_RTR_FLAG;
  return id;
}

std::uint32_t from_kernel_id(std::uint32_t kernel_id, std::uint8_t& flags) noexcept {
  if ((kernel_id & CAN_ERR_FLAG) != 0) {
    flags = kCanError;
    return kernel_id & CAN_ERR_MASK;
  }
  const bool extended = (kernel_id & CAN_EFF_FLAG) != 0;
  flags = static_cast<std::uint8_t>(extended ? kCanExtended : 0);
  if ((kernel_id & CAN_RTR_FLAG) != 0) flags = static_cast<std::uint8_t>(flags | kCanRemote);
  return kernel_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
}

void CanSocketPath::use(int descriptor, rt::Nanoseconds epoch_ns, Opener opener, void* context) noexcept {
  close();
  descriptor_ = descriptor;
  epoch_ns_ = epoch_ns;
  opener_ = opener;
  context_ = context;
  bus_off_ = gone_ = false;
  kernel_overruns_ = 0;
  counters_ = {};
}

void CanSocketPath::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  opener_ = nullptr;
}

bool CanSocketPath::try_again(rt::Nanoseconds every_ns) noexcept {
  const rt::Nanoseconds now_ns = rt::posix::monotonic_now();
  if (now_ns - tried_ns_ < every_ns) return false;
  tried_ns_ = now_ns;
  return true;
}

// True: there is an interface behind the socket, as far as is known.
bool CanSocketPath::there() noexcept {
  if (!gone_) return descriptor_ >= 0;
  if (opener_ == nullptr || !try_again(kReopenEvery)) return false;
  const int opened = opener_(context_);
  if (opened < 0) return false;
  ::close(descriptor_);
  descriptor_ = opened;
  gone_ = bus_off_ = false;
  kernel_overruns_ = 0;  // each socket counts its own
  ++counters_.reopened;
  return true;
}

Status CanSocketPath::failed(int error, Status when_busy) noexcept {
  if (means_gone(error) && !gone_) {
    gone_ = true;
    tried_ns_ = 0;
  }
  return meaning_of(error, when_busy);
}

Status CanSocketPath::send(const void* packet, std::size_t bytes) noexcept {
  if (!there()) return Status::disconnected;
  if (bus_off_ && !try_again(kProbeEvery)) return Status::disconnected;
  if (::send(descriptor_, packet, bytes, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(bytes)) {
    if (bus_off_) return Status::disconnected;  // nobody knows where it went
    ++counters_.sent;
    return Status::ok;
  }
  const Status status = failed(errno, Status::full);
  if (status == Status::full) ++counters_.tx_refused;
  return status;
}

Status CanSocketPath::receive(void* to, std::size_t room, std::size_t& bytes,
                              rt::Nanoseconds& stamp_ns) noexcept {
  if (!there()) return Status::disconnected;
  iovec data{to, room};
  alignas(cmsghdr) char control[kKernelNoteBytes];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t taken = ::recvmsg(descriptor_, &message, MSG_DONTWAIT);
  // 0: the other end of a local socket is gone.
  if (taken <= 0) return failed(taken < 0 ? errno : EPIPE, Status::empty);
  if ((message.msg_flags & MSG_TRUNC) != 0) return Status::malformed;
  const KernelNote note = read_kernel_note(message);
  bytes = static_cast<std::size_t>(taken);
  stamp_ns = note.stamp_ns - epoch_ns_;
  if (note.counts_overruns) {
    // The total wraps.
    counters_.rx_overrun += static_cast<std::uint32_t>(note.overruns - kernel_overruns_);
    kernel_overruns_ = note.overruns;
  }
  return Status::ok;
}

void CanSocketPath::note(std::uint8_t flags, std::uint32_t id, std::uint8_t controller) noexcept {
  if ((flags & kCanError) == 0) {
    ++counters_.received;
    bus_off_ = false;  // only a controller that is on the bus hears it
    return;
  }
  ++counters_.error_frames;
  const bool off = (id & CAN_ERR_BUSOFF) != 0;
  const bool active = (id & CAN_ERR_CRTL) != 0 && (controller & CAN_ERR_CRTL_ACTIVE) != 0;
  if (off && !bus_off_) {
    ++counters_.bus_off;
    tried_ns_ = rt::posix::monotonic_now();
  }
  if (off) bus_off_ = true;
  if ((id & CAN_ERR_RESTARTED) != 0 || active) bus_off_ = false;
}

// Classical frames in the kernel's form, and back.
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
