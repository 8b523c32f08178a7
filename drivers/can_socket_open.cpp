// SPDX-License-Identifier: BSD-3-Clause
// Opening a SocketCAN port: start-up code, with a cure for everything that usually goes wrong.
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

#include "drivers/can_socket_path.hpp"

namespace sortie::drivers {

namespace {

constexpr std::size_t kMostFilters = 32;

/// How far opening came. Where it failed, the system's error.
enum class OpenStep : std::uint8_t {
  done,
  socket,
  stamps,
  overruns,
  buffer,
  error_frames,
  filters,
  name,
  find,
  number,
  bind,
  down,
  fd_width,
  fd,
};
struct Opened {
  OpenStep step{};
  int error{};
  int descriptor{-1};
};

template <class Value>
bool set_option(int descriptor, int level, int option, const Value& value) noexcept {
  return ::setsockopt(descriptor, level, option, &value, sizeof value) == 0;
}

OpenStep set_options(int descriptor, const SocketCanConfig& config) noexcept {
  const int on = 1;
  if (!set_option(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, on)) return OpenStep::stamps;
  if (!set_option(descriptor, SOL_SOCKET, SO_RXQ_OVFL, on)) return OpenStep::overruns;
  if (config.receive_buffer_bytes > 0 &&
      !set_option(descriptor, SOL_SOCKET, SO_RCVBUF, config.receive_buffer_bytes))
    return OpenStep::buffer;
  // Lost arbitration is daily life on a bus and would flood the queue.
  const can_err_mask_t errors = config.error_frames ? CAN_ERR_MASK & ~CAN_ERR_LOSTARB : 0;
  if (!set_option(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors)) return OpenStep::error_frames;
  if (config.filters.empty()) return OpenStep::done;
  can_filter filters[kMostFilters];
  std::size_t count = 0;
  for (const SocketCanFilter& f : config.filters) {
    if (count == kMostFilters) return OpenStep::filters;
    filters[count++] = {f.extended ? f.id | CAN_EFF_FLAG : f.id, f.mask | CAN_EFF_FLAG};
  }
  const auto bytes = static_cast<socklen_t>(count * sizeof(can_filter));
  return ::setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FILTER, filters, bytes) == 0 ? OpenStep::done
                                                                                    : OpenStep::filters;
}

OpenStep bind_to(int descriptor, const std::string& name, CanSocketKind kind) noexcept {
  ifreq request{};
  if (name.empty() || name.size() >= sizeof request.ifr_name) return OpenStep::name;
  std::memcpy(request.ifr_name, name.c_str(), name.size() + 1);
  if (::ioctl(descriptor, SIOCGIFFLAGS, &request) != 0) return OpenStep::find;
  const bool up = (request.ifr_flags & IFF_UP) != 0;
  if (::ioctl(descriptor, SIOCGIFINDEX, &request) != 0) return OpenStep::number;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return OpenStep::bind;
  if (!up) return OpenStep::down;
  if (kind != CanSocketKind::fd) return OpenStep::done;
  if (::ioctl(descriptor, SIOCGIFMTU, &request) != 0 || request.ifr_mtu < static_cast<int>(CANFD_MTU))
    return OpenStep::fd_width;
  return set_option(descriptor, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1) ? OpenStep::done : OpenStep::fd;
}

Opened try_open(const SocketCanConfig& config, CanSocketKind kind) noexcept {
  const int descriptor = ::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (descriptor < 0) return {OpenStep::socket, errno};
  OpenStep step = set_options(descriptor, config);
  if (step == OpenStep::done) step = bind_to(descriptor, config.interface, kind);
  if (step == OpenStep::done) return {step, 0, descriptor};
  const int error = errno;
  ::close(descriptor);
  return {step, error};
}

bool lacks_can(const Opened& opened) {
  return opened.step == OpenStep::socket && (opened.error == EAFNOSUPPORT || opened.error == EPROTONOSUPPORT);
}

// What is wrong, and the cure.
std::string explain(const Opened& opened, const std::string& name) {
  const std::string why = " (" + std::generic_category().message(opened.error) + ")";
  const std::string the = "SocketCAN: interface '" + name + "' ";
  const auto refused = [&](const char* what) {
    return std::string("SocketCAN: the kernel refuses ") + what + why;
  };
  switch (opened.step) {
    case OpenStep::done:
      return {};
    case OpenStep::socket:
      if (lacks_can(opened))
        return "SocketCAN: this kernel has no CAN (AF_CAN); load it (modprobe can_raw), use a kernel with "
               "CONFIG_CAN, or run against the simulated bus";
      return "SocketCAN: no socket" + why;
    case OpenStep::stamps:
      return refused("time stamps");
    case OpenStep::overruns:
      return refused("the overrun count");
    case OpenStep::buffer:
      return refused("this receive buffer");
    case OpenStep::error_frames:
      return refused("error frames");
    case OpenStep::filters:
      return refused("these filters") + "; 32 are the most";
    case OpenStep::name:
      return "SocketCAN: '" + name + "' is no interface name; it has 1 to 15 characters, such as can0";
    case OpenStep::find:
      return "SocketCAN: there is no interface '" + name + "'" + why +
             "; see 'ip -br link', or make a virtual one: ip link add dev " + name + " type vcan";
    case OpenStep::number:
      return the + "went away" + why;
    case OpenStep::bind:
      return the + "cannot be used" + why + "; is it a CAN interface? see 'ip -d link show " + name + "'";
    case OpenStep::down:
      return the + "is down; ip link set " + name + " up type can bitrate 500000";
    case OpenStep::fd_width:
      return the + "carries no CAN FD frames; where its controller can, ip link set " + name +
             " down, then ip link set " + name +
             " up type can bitrate 500000 dbitrate 2000000 fd on; a virtual one: ip link set " + name +
             " mtu 72 while it is down";
    case OpenStep::fd:
      return refused("CAN FD frames");
  }
  return {};
}

}  // namespace

Status CanSocketPath::open(const SocketCanConfig& config, CanSocketKind kind, std::string& problem) {
  close();
  const Opened opened = try_open(config, kind);
  if (opened.step != OpenStep::done) {
    problem = explain(opened, config.interface);
    const bool narrow = opened.step == OpenStep::fd_width || opened.step == OpenStep::fd;
    return lacks_can(opened) || narrow ? Status::not_supported : Status::disconnected;
  }
  config_ = config;
  kind_ = kind;
  // It could be opened once: without memory, and without words.
  const auto again = [](void* self) {
    const auto& path = *static_cast<const CanSocketPath*>(self);
    return try_open(path.config_, path.kind_).descriptor;
  };
  use(opened.descriptor, config.epoch_ns, again, this);
  return Status::ok;
}

}  // namespace sortie::drivers
