// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <cstring>
#include <span>
#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/group_sender.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_requests.hpp"
#include "hil/board/board_jobs.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::hil {

namespace {

constexpr std::size_t kMostBytes = 1400;

class Weather {
 public:
  std::span<const std::uint8_t> next() {
    size_ = 0;
    switch (draw() % 5) {
      case 0:
        add_noise(below(kMostBytes));
        break;
      case 1:
        add_header("LC02", "NOISE");
        add_noise(below(200));
        break;
      case 2:  // a fragment: size, offset, number and count come from the stranger
        add_header("LC03", "");
        add_noise(12 + below(1000));
        break;
      case 3:
        add_header("LC02", drivers::kChannelSet);
        add_request(
            drivers::SetParameter{number(), number(), number(), number(), {0, "drive.max_speed_m_s", 0.1}});
        break;
      default: {
        add_header("LC02", drivers::kChannelDrive);
        drivers::DriveRequestMessage request;
        request.session = number();
        request.counter = number();
        request.speed_m_s = 1.0;
        add_request(request);
      }
    }
    return {bytes_.data(), size_};
  }

 private:
  // xorshift64 (Marsaglia 2003).
  std::uint64_t draw() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return state_;
  }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(draw() % end); }
  std::int64_t number() { return static_cast<std::int64_t>(draw() >> 1); }
  void add_noise(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) bytes_[size_++] = static_cast<std::uint8_t>(draw());
  }
  void add_header(std::string_view magic, std::string_view channel) {
    std::memcpy(bytes_.data(), magic.data(), 4);
    size_ = 4;
    add_noise(4);
    std::memcpy(bytes_.data() + size_, channel.data(), channel.size());
    size_ += channel.size();
    bytes_[size_++] = 0;
  }
  // Tagged with a secret of the sender's own; then up to three bytes of the whole are changed.
  template <class Request>
  void add_request(const Request& request) {
    drivers::SipKey key{};
    key[0] = static_cast<std::uint8_t>(draw());
    std::size_t size = 0;
    if (encode(request, &key, std::span(bytes_).subspan(size_), size) != Status::ok) size = 0;
    size_ += size;
    for (std::size_t i = below(4); i > 0; --i) bytes_[below(size_)] = static_cast<std::uint8_t>(draw());
  }

  std::uint64_t state_{1};
  std::array<std::uint8_t, 2048> bytes_{};
  std::size_t size_{};
};

}  // namespace

int storm(const std::string& url, std::uint32_t datagrams, std::uint32_t per_ms) {
  if (per_ms == 0) return complain("storm wants at least one datagram a millisecond");
  drivers::GroupSender sender(url);
  Weather weather;
  std::uint32_t refused = 0;
  rt::Nanoseconds release_ns = rt::posix::monotonic_now();
  for (std::uint32_t i = 0; i < datagrams; ++i) {
    if (i % per_ms == 0) {
      release_ns += rt::kNanosecondsPerMillisecond;
      rt::posix::sleep_until(release_ns);
    }
    if (sender.send(weather.next()) != Status::ok) ++refused;
  }
  std::printf("{\"datagrams\": %u, \"refused\": %u}\n", datagrams, refused);
  return refused == 0 ? 0 : 1;
}

}  // namespace sortie::hil
