// SPDX-License-Identifier: BSD-3-Clause
// A multicast socket, and one datagram at a time from it.
#include "drivers/lcm_receiver.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <stdexcept>

#include "drivers/channels.hpp"
#include "drivers/wire_cursor.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::drivers {
namespace {

[[noreturn]] void refuse(int fd, const std::string& url, const char* step, const char* cure) {
  const std::string why = std::strerror(errno);
  if (fd >= 0) ::close(fd);
  throw std::runtime_error("LCM address \"" + url + "\": cannot " + step + ": " + why + "; " + cure);
}

template <class Value>
bool set(int fd, int level, int option, const Value& value) {
  return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

rt::Nanoseconds arrival(msghdr& header) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec time{};
    std::memcpy(&time, CMSG_DATA(part), sizeof time);
    return std::int64_t{time.tv_sec} * rt::kNanosecondsPerSecond + std::int64_t{time.tv_nsec};
  }
  // No stamp from this kernel (emulators have none): the time of taking it has to do.
  return rt::posix::read_clock(CLOCK_REALTIME);
}

}  // namespace

Status parse_lc02(std::span<const std::uint8_t> datagram, Lc02Message& message) noexcept {
  constexpr std::uint32_t kWholeMessage = 0x4c433032u;
  constexpr std::uint32_t kFragmentMessage = 0x4c433033u;
  WireReader reader(datagram);
  const auto magic = reader.get<std::uint32_t>();
  const auto sequence = reader.get<std::uint32_t>();
  if (reader.status() != Status::ok) return Status::malformed;
  if (magic == kFragmentMessage) return Status::not_supported;
  if (magic != kWholeMessage) return Status::malformed;

  const auto rest = reader.get_bytes(reader.left());
  const std::string_view text(reinterpret_cast<const char*>(rest.data()), rest.size());
  const std::size_t length = text.substr(0, kMaxChannelLength + 1).find('\0');
  if (length == 0 || length == std::string_view::npos) return Status::malformed;
  message.sequence = sequence;
  message.channel = text.substr(0, length);
  message.payload = rest.subspan(length + 1);
  return Status::ok;
}

LcmReceiver::LcmReceiver(const std::string& url, std::span<const FilterRule> any_of)
    : buffer_(std::make_unique<std::uint8_t[]>(kMaxDatagram)) {
  const MulticastAddress address = parse_udpm_url(url);
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) refuse(fd, url, "open a socket", "this system must allow UDP");
  const int on = 1;
  if (!set(fd, SOL_SOCKET, SO_REUSEADDR, on))
    refuse(fd, url, "share the port", "end the program that holds it alone");
  if (address.receive_buffer != 0) {
    // The kernel may grant less; that only shows as lost messages.
    static_cast<void>(set(fd, SOL_SOCKET, SO_RCVBUF, static_cast<int>(address.receive_buffer)));
  }
  static_cast<void>(set(fd, SOL_SOCKET, SO_TIMESTAMPNS, on));
  if (!any_of.empty() && !set_filter(fd, any_of))
    refuse(fd, url, "choose datagrams", "this kernel has no socket filters (CONFIG_NET)");
  // Bound to the group, the socket takes no datagram that was sent to this computer directly.
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(address.port);
  name.sin_addr.s_addr = htonl(address.group);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0) {
    refuse(fd, url, "bind the port", "another program holds it, or it needs rights");
  }
  ip_mreq membership{};
  membership.imr_multiaddr.s_addr = htonl(address.group);
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (!set(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership)) {
    refuse(fd, url, "join the group", "give multicast a route: ip route add 224.0.0.0/4 dev lo");
  }
  fd_ = fd;
}

LcmReceiver::~LcmReceiver() {
  if (fd_ >= 0) ::close(fd_);
}

Status LcmReceiver::receive(ReceivedMessage& received, int timeout_ms) noexcept {
  pollfd waiting{fd_, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, timeout_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return Status::empty;

  iovec part{buffer_.get(), kMaxDatagram};
  alignas(cmsghdr) char control[128];
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control;
  header.msg_controllen = sizeof control;
  const ssize_t size = ready < 0 ? -1 : ::recvmsg(fd_, &header, 0);
  if (size < 0) {
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return Status::empty;
    ++counters_.socket_errors;
    return Status::disconnected;
  }
  Status status = Status::malformed;
  if ((header.msg_flags & MSG_TRUNC) == 0) {
    status = parse_lc02({buffer_.get(), static_cast<std::size_t>(size)}, received.message);
  }
  if (status == Status::not_supported) ++counters_.fragments;
  if (status == Status::malformed) ++counters_.malformed;
  if (status != Status::ok) return status;
  received.stamp_ns = arrival(header);
  ++counters_.messages;
  counters_.bytes += received.message.payload.size();
  return Status::ok;
}

}  // namespace sortie::drivers
