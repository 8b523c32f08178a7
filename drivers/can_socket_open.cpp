// SPDX-License-Identifier: BSD-3-Clause
// Opening a SocketCAN port: start-up code, with a cure for everything that usually goes wrong.
#include "drivers/can_socket_open.hpp"

#if defined(__linux__)
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#endif

namespace sortie::drivers {

#if defined(__linux__)

namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// Closes the socket unless it was handed on.
struct Guard {
  int descriptor;
  ~Guard() {
    if (descriptor >= 0) ::close(descriptor);
  }
  int release() {
    const int d = descriptor;
    descriptor = -1;
    return d;
  }
};

bool set(int descriptor, int level, int option, const void* value, std::size_t size, const char* name,
         std::string& problem) {
  if (::setsockopt(descriptor, level, option, value, static_cast<socklen_t>(size)) == 0) return true;
  problem = std::string("SocketCAN: the kernel refuses ") + name + " (" + reason(errno) + ")";
  return false;
}

bool set_options(int descriptor, const SocketCanConfig& config, std::string& problem) {
  const int on = 1;
  if (!set(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on, "time stamps", problem)) return false;
  if (!set(descriptor, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on, "the overrun count", problem)) return false;
  if (config.receive_buffer_bytes > 0 &&
      !set(descriptor, SOL_SOCKET, SO_RCVBUF, &config.receive_buffer_bytes,
           sizeof config.receive_buffer_bytes, "this receive buffer", problem)) {
    return false;
  }
  // Lost arbitration is daily life on a bus and would flood the queue.
  const can_err_mask_t errors = config.error_frames ? CAN_ERR_MASK & ~CAN_ERR_LOSTARB : 0;
  if (!set(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors, "error frames", problem)) {
    return false;
  }
  if (config.filters.empty()) return true;
  std::vector<can_filter> filters;
  for (const SocketCanFilter& f : config.filters) {
    filters.push_back({f.extended ? f.id | CAN_EFF_FLAG : f.id, f.mask | CAN_EFF_FLAG});
  }
  return set(descriptor, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), filters.size() * sizeof(can_filter),
             "these filters", problem);
}

Status bind_to(int descriptor, const std::string& name, std::string& problem) {
  ifreq request{};
  if (name.empty() || name.size() >= sizeof request.ifr_name) {
    problem = "SocketCAN: '" + name + "' is no interface name; it has 1 to 15 characters, such as can0";
    return Status::disconnected;
  }
  std::memcpy(request.ifr_name, name.c_str(), name.size() + 1);
  if (::ioctl(descriptor, SIOCGIFFLAGS, &request) != 0) {
    problem = "SocketCAN: there is no interface '" + name + "' (" + reason(errno) +
              "); see 'ip -br link', or make a virtual one: ip link add dev " + name + " type vcan";
    return Status::disconnected;
  }
  const bool up = (request.ifr_flags & IFF_UP) != 0;
  if (::ioctl(descriptor, SIOCGIFINDEX, &request) != 0) {
    problem = "SocketCAN: interface '" + name + "' went away (" + reason(errno) + ")";
    return Status::disconnected;
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    problem = "SocketCAN: interface '" + name + "' cannot be used (" + reason(errno) +
              "); is it a CAN interface? see 'ip -d link show " + name + "'";
    return Status::disconnected;
  }
  if (!up) {
    problem =
        "SocketCAN: interface '" + name + "' is down; ip link set " + name + " up type can bitrate 500000";
    return Status::disconnected;
  }
  return Status::ok;
}

// Bound sockets only: asks the interface, and tells the socket.
bool carries_fd(int descriptor, const std::string& name, std::string& problem) {
  ifreq request{};
  std::memcpy(request.ifr_name, name.c_str(), name.size() + 1);
  if (::ioctl(descriptor, SIOCGIFMTU, &request) != 0 || request.ifr_mtu < static_cast<int>(CANFD_MTU)) {
    problem = "SocketCAN: interface '" + name +
              "' carries no CAN FD frames; where its controller can, ip link set " + name +
              " down, then ip link set " + name +
              " up type can bitrate 500000 dbitrate 2000000 fd on; a virtual one: ip link set " + name +
              " mtu 72 while it is down";
    return false;
  }
  const int on = 1;
  return set(descriptor, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on, "CAN FD frames", problem);
}

}  // namespace

Status meaning_of_can_error(int error, Status when_busy) noexcept {
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

CanPacket take_can_packet(int descriptor, void* to, std::size_t room) noexcept {
  CanPacket packet;
  iovec data{to, room};
  alignas(cmsghdr) char control[kKernelNoteBytes];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t taken = ::recvmsg(descriptor, &message, MSG_DONTWAIT);
  if (taken < 0) {
    packet.status = meaning_of_can_error(errno, Status::empty);
  } else if (taken == 0) {
    packet.status = Status::disconnected;
  } else if ((message.msg_flags & MSG_TRUNC) != 0) {
    packet.status = Status::malformed;
  } else {
    packet.bytes = static_cast<std::size_t>(taken);
    packet.note = read_kernel_note(message);
  }
  return packet;
}

Status open_can_socket(const SocketCanConfig& config, CanSocketKind kind, int& descriptor,
                       std::string& problem) {
  Guard guard{::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)};
  if (guard.descriptor < 0) {
    const int error = errno;
    if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT) {
      problem =
          "SocketCAN: this kernel has no CAN (AF_CAN); load it (modprobe can_raw), use a kernel with "
          "CONFIG_CAN, or run against the simulated bus";
      return Status::not_supported;
    }
    problem = "SocketCAN: no socket (" + reason(error) + ")";
    return Status::disconnected;
  }
  if (!set_options(guard.descriptor, config, problem)) return Status::disconnected;
  const Status bound = bind_to(guard.descriptor, config.interface, problem);
  if (bound != Status::ok) return bound;
  if (kind == CanSocketKind::fd && !carries_fd(guard.descriptor, config.interface, problem))
    return Status::not_supported;
  descriptor = guard.release();
  return Status::ok;
}

Status SocketCan::open(const SocketCanConfig& config, std::string& problem) {
  close();
  int descriptor = -1;
  const Status status = open_can_socket(config, CanSocketKind::classical, descriptor, problem);
  if (status == Status::ok) adopt(descriptor, config.epoch_ns);
  return status;
}

#else

Status SocketCan::open(const SocketCanConfig&, std::string& problem) {
  problem = "SocketCAN: only Linux has it; run against the simulated bus";
  return Status::not_supported;
}

#endif

}  // namespace sortie::drivers
