// SPDX-License-Identifier: BSD-3-Clause
// The other end of a datagram link, written by hand from the form that its header gives: it can also do what
// no honest peer does.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "drivers/datagram_link.hpp"

namespace sortie::test {

using Datagram = std::vector<std::uint8_t>;

/// A UDP socket on the loopback; port 0: any free one.
class LoopbackSocket {
 public:
  explicit LoopbackSocket(std::uint16_t port = 0) : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in name = address(port);
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0);
    socklen_t length = sizeof name;
    REQUIRE(::getsockname(fd_, reinterpret_cast<sockaddr*>(&name), &length) == 0);
    port_ = ntohs(name.sin_port);
  }
  ~LoopbackSocket() { ::close(fd_); }
  LoopbackSocket(const LoopbackSocket&) = delete;
  LoopbackSocket& operator=(const LoopbackSocket&) = delete;

  std::uint16_t port() const { return port_; }
  void send(std::uint16_t to, const Datagram& bytes) const {
    const sockaddr_in name = address(to);
    REQUIRE(::sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&name),
                     sizeof name) == static_cast<ssize_t>(bytes.size()));
  }
  /// The oldest datagram that waits, or an empty one; `from` becomes its sender.
  Datagram take(std::uint16_t& from) const {
    Datagram bytes(65536);
    sockaddr_in name{};
    socklen_t length = sizeof name;
    const ssize_t size = ::recvfrom(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT,
                                    reinterpret_cast<sockaddr*>(&name), &length);
    bytes.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    if (size >= 0) from = ntohs(name.sin_port);
    return bytes;
  }

 private:
  static sockaddr_in address(std::uint16_t port) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(port);
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return name;
  }
  int fd_;
  std::uint16_t port_{};
};

/// A port that was free a moment ago.
inline std::uint16_t free_port() { return LoopbackSocket().port(); }

template <class Unsigned>
void append_big_endian(Datagram& bytes, Unsigned value) {
  for (int i = static_cast<int>(sizeof(Unsigned)) - 1; i >= 0; --i)
    bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i) & 0xffu));
}

/// What stands before a payload. kind: 1 hello, 2 data, 3 bye.
struct ScriptedHead {
  std::uint32_t magic{0x5372744Cu};
  std::uint8_t version{1};
  std::uint8_t purpose{1};
  std::uint8_t kind{2};
  std::uint8_t zero{0};
  std::uint64_t from{};
  std::uint64_t to{};
  std::uint32_t number{};
};

inline Datagram scripted(const ScriptedHead& head, const Datagram& payload = {}) {
  Datagram bytes;
  append_big_endian(bytes, head.magic);
  for (const std::uint8_t byte : {head.version, head.purpose, head.kind, head.zero}) bytes.push_back(byte);
  append_big_endian(bytes, head.from);
  append_big_endian(bytes, head.to);
  append_big_endian(bytes, head.number);
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

/// Session numbers of both ends in these tests.
inline constexpr std::uint64_t kPlantSession = 0x1111222233334444u;
inline constexpr std::uint64_t kRuntimeSession = 0x5555666677778888u;

inline drivers::DatagramLinkConfig plant_end(std::uint16_t port, std::uint64_t session = kPlantSession) {
  drivers::DatagramLinkConfig config;
  config.port = port;
  config.listens = true;
  config.session = session;
  return config;
}
inline drivers::DatagramLinkConfig runtime_end(std::uint16_t port, std::uint64_t session = kRuntimeSession) {
  drivers::DatagramLinkConfig config;
  config.port = port;
  config.session = session;
  config.hello_every_ns = 0;  // at every call, so that no test waits
  return config;
}

}  // namespace sortie::test
