// SPDX-License-Identifier: BSD-3-Clause
// Puts a test into a network of its own, so that nothing it sends can reach a real one.
#pragma once

#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace sortie::test {

/// Moves the calling thread, and those it starts later, into a fresh network namespace with a loopback that
/// carries multicast. Empty, or why this system does not allow it. Done once per process; there is no way
/// back.
inline std::string enter_own_network() {
  static bool done = false;
  if (done) return {};
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
    return std::string("no network namespace of its own: ") + std::strerror(errno);
  }
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq loopback{};
  std::memcpy(loopback.ifr_name, "lo", 3);
  loopback.ifr_flags = IFF_UP | IFF_LOOPBACK | IFF_RUNNING | IFF_MULTICAST;
  bool good = fd >= 0 && ioctl(fd, SIOCSIFFLAGS, &loopback) == 0;
  rtentry route{};
  const auto address = [](sockaddr& out, std::uint32_t value) {
    sockaddr_in in{};
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(value);
    std::memcpy(&out, &in, sizeof in);
  };
  address(route.rt_dst, 0xE0000000u);
  address(route.rt_genmask, 0xF0000000u);
  char device[] = "lo";
  route.rt_dev = device;
  route.rt_flags = RTF_UP;
  good = good && ioctl(fd, SIOCADDRT, &route) == 0;
  const std::string why = std::strerror(errno);
  if (fd >= 0) close(fd);
  if (!good) return "the loopback of a network namespace cannot be set up: " + why;
  done = true;
  return {};
}

}  // namespace sortie::test
