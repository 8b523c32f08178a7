// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/datagram_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/kernel_stamp.hpp"
#include "drivers/wire_cursor.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kMagic = 0x5372744Cu;  // "SrtL"
constexpr std::uint8_t kVersion = 1;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(port);
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return name;
}

bool not_taken(std::uint64_t& counter) {
  ++counter;
  return false;
}

}  // namespace

Status DatagramLink::open(const DatagramLinkConfig& config, std::string& problem) {
  close();
  if (config.port == 0 || config.session == 0) {
    problem = "a link needs a port from 1 to 65535 and a session number";
    return Status::out_of_range;
  }
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) {
    problem = std::string("no UDP socket: ") + std::strerror(errno);
    return Status::disconnected;
  }
  const int on = 1;
  // What the kernel does not grant shows as overruns, and as stamps of taking instead of arrival.
  static_cast<void>(::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &config.receive_buffer_bytes, sizeof(int)));
  static_cast<void>(::setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on));
  static_cast<void>(::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on));
  const sockaddr_in name = loopback(config.listens ? config.port : std::uint16_t{0});
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0) {
    problem = "UDP port " + std::to_string(config.port) + " of 127.0.0.1: " + std::strerror(errno) +
              "; is another plant running? Choose another port";
    ::close(fd);
    return Status::disconnected;
  }
  config_ = config;
  descriptor_ = fd;
  has_peer_ = false;
  peer_ = 0;
  peer_port_ = config.listens ? std::uint16_t{0} : config.port;
  next_hello_ns_ = 0;
  polled_ns_ = rt::posix::monotonic_now();
  number_ = 0;
  kernel_overruns_ = 0;
  counters_ = {};
  return Status::ok;
}

void DatagramLink::close() noexcept {
  if (descriptor_ < 0) return;
  if (has_peer_) static_cast<void>(put(Kind::bye, peer_, {}));  // lost: the peer notices the silence
  ::close(descriptor_);
  descriptor_ = -1;
  has_peer_ = false;
}

Status DatagramLink::put(Kind kind, std::uint64_t to, std::span<const std::uint8_t> payload) noexcept {
  WireWriter writer(out_);
  writer.put(kMagic);
  writer.put(kVersion);
  writer.put(static_cast<std::uint8_t>(config_.purpose));
  writer.put(static_cast<std::uint8_t>(kind));
  writer.put(std::uint8_t{0});
  writer.put(config_.session);
  writer.put(to);
  writer.put(number_);
  writer.put_array(payload.data(), payload.size());
  if (writer.status() != Status::ok) return Status::out_of_range;
  const sockaddr_in name = loopback(peer_port_);
  const ssize_t sent = ::sendto(descriptor_, out_.data(), writer.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&name), sizeof name);
  if (sent != static_cast<ssize_t>(writer.size())) {
    ++counters_.send_refused;
    return Status::full;
  }
  ++number_;
  ++counters_.sent;
  if (kind != Kind::data) ++counters_.greetings_sent;
  return Status::ok;
}

Status DatagramLink::send(std::span<const std::uint8_t> payload) noexcept {
  if (descriptor_ < 0) return Status::disconnected;
  if (payload.size() > kMaxPayload) return Status::out_of_range;
  if (!has_peer_) {
    ++counters_.send_unheard;
    return Status::disconnected;
  }
  return put(Kind::data, peer_, payload);
}

void DatagramLink::greet(rt::Nanoseconds now_ns) noexcept {
  if (config_.listens || now_ns < next_hello_ns_) return;
  next_hello_ns_ = now_ns + config_.hello_every_ns;
  static_cast<void>(put(Kind::hello, 0, {}));  // the next one comes soon
}

bool DatagramLink::read_head(std::span<const std::uint8_t> datagram, Head& head) noexcept {
  WireReader reader(datagram);
  const auto magic = reader.get<std::uint32_t>();
  const auto version = reader.get<std::uint8_t>();
  const auto purpose = reader.get<std::uint8_t>();
  const auto kind = reader.get<std::uint8_t>();
  const auto zero = reader.get<std::uint8_t>();
  head.from = reader.get<std::uint64_t>();
  head.to = reader.get<std::uint64_t>();
  head.number = reader.get<std::uint32_t>();
  head.kind = static_cast<Kind>(kind);
  return reader.status() == Status::ok && magic == kMagic && version == kVersion &&
         purpose == static_cast<std::uint8_t>(config_.purpose) && kind >= 1 && kind <= 3 && zero == 0 &&
         head.from != 0 && (head.kind == Kind::data || reader.left() == 0);
}

// A life of the other end that was not met before. The listening end believes a greeting, and only while
// nobody else is there; the other end believes who holds the port and knows its session.
bool DatagramLink::admit_peer(const Head& head, std::uint16_t port) noexcept {
  const bool good = config_.listens ? head.kind == Kind::hello && !has_peer_ : head.kind != Kind::bye;
  if (!good) return not_taken(counters_.wrong_session);
  ++counters_.peers;
  peer_ = head.from;
  peer_port_ = port;
  peer_number_ = head.number - 1;
  return true;
}

bool DatagramLink::admit(const Head& head, std::uint16_t port, rt::Nanoseconds stamp_ns) noexcept {
  const bool addressed =
      head.kind == Kind::hello && config_.listens ? head.to == 0 : head.to == config_.session;
  if (!addressed) return not_taken(counters_.wrong_session);
  if (head.from != peer_ && !admit_peer(head, port)) return false;
  if (config_.listens && port != peer_port_) return not_taken(counters_.foreign);
  const auto ahead = static_cast<std::int32_t>(head.number - peer_number_);
  if (ahead <= 0) return not_taken(counters_.repeated);
  counters_.lost += static_cast<std::uint64_t>(ahead - 1);
  peer_number_ = head.number;
  heard_ns_ = stamp_ns;
  has_peer_ = head.kind != Kind::bye;
  if (head.kind != Kind::data) ++counters_.greetings;
  if (config_.listens && head.kind == Kind::hello)
    static_cast<void>(put(Kind::hello, peer_, {}));  // answered, so that the peer knows this end without data
  return head.kind == Kind::data;
}

Status DatagramLink::receive(std::span<const std::uint8_t>& payload, rt::Nanoseconds& stamp_ns) noexcept {
  if (descriptor_ < 0) return Status::disconnected;
  bool drained = false;
  for (int i = 0; i < kMostRefusedPerCall && !drained; ++i) {
    sockaddr_in source{};
    iovec data{in_.data(), in_.size()};
    alignas(cmsghdr) char control[kKernelNoteBytes];
    msghdr message{};
    message.msg_name = &source;
    message.msg_namelen = sizeof source;
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    const ssize_t taken = ::recvmsg(descriptor_, &message, MSG_DONTWAIT);
    if (taken < 0) {
      drained = true;
      continue;
    }
    const KernelNote note = read_kernel_note(message);
    if (note.counts_overruns) {
      counters_.overruns += static_cast<std::uint32_t>(note.overruns - kernel_overruns_);  // the total wraps
      kernel_overruns_ = note.overruns;
    }
    const std::uint16_t port = ntohs(source.sin_port);
    Head head;
    if ((message.msg_flags & MSG_TRUNC) != 0) {
      ++counters_.oversized;
    } else if ((!config_.listens && port != peer_port_) ||
               !read_head({in_.data(), static_cast<std::size_t>(taken)}, head)) {
      ++counters_.foreign;
    } else if (admit(head, port, note.stamp_ns)) {
      ++counters_.data;
      payload = {in_.data() + kHeadBytes, static_cast<std::size_t>(taken) - kHeadBytes};
      stamp_ns = note.stamp_ns;
      return Status::ok;
    }
  }
  // Silence is the peer's only where all that waited has been heard and this end itself was there.
  const rt::Nanoseconds now_ns = rt::posix::monotonic_now();
  if (!drained || now_ns - polled_ns_ > config_.silence_ns / 2) heard_ns_ = now_ns;
  polled_ns_ = now_ns;
  if (has_peer_ && now_ns - heard_ns_ > config_.silence_ns) has_peer_ = false;
  greet(now_ns);
  return Status::empty;
}

}  // namespace sortie::drivers
