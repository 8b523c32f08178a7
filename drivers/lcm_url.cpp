// SPDX-License-Identifier: BSD-3-Clause
// Takes LCM addresses apart; every number is range-checked.
#include "drivers/lcm_url.hpp"

#include <charconv>
#include <stdexcept>

namespace sortie::drivers {
namespace {

constexpr std::uint32_t kDefaultGroup = 0xEFFF4C43u;  // 239.255.76.67
constexpr std::uint16_t kDefaultPort = 7667;
constexpr std::uint32_t kMaxBuffer = 1u << 30;

[[noreturn]] void refuse(std::string_view url, const char* why) {
  throw std::runtime_error("LCM address \"" + std::string(url) + "\": " + why + "; it should look like " +
                           std::string(kDefaultLcmUrl));
}

bool parse_number(std::string_view text, std::uint32_t max, std::uint32_t& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && stop == end && value <= max;
}

bool parse_group(std::string_view text, std::uint32_t& group) {
  group = 0;
  for (int part = 0; part < 4; ++part) {
    const std::size_t dot = text.find('.');
    std::uint32_t byte = 0;
    if ((dot == std::string_view::npos) != (part == 3) || !parse_number(text.substr(0, dot), 255, byte))
      return false;
    group = (group << 8) | byte;
    text.remove_prefix(part == 3 ? text.size() : dot + 1);
  }
  return true;
}

}  // namespace

MulticastAddress parse_udpm_url(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) refuse(url, "only udpm:// can be listened to");
  MulticastAddress address{kDefaultGroup, kDefaultPort, 0};
  std::string_view rest = url.substr(kScheme.size());
  const std::size_t question = rest.find('?');
  std::string_view options = question == std::string_view::npos ? "" : rest.substr(question + 1);
  rest = rest.substr(0, question);
  const std::size_t colon = rest.find(':');
  const std::string_view group = rest.substr(0, colon);
  if (!group.empty() && !parse_group(group, address.group)) refuse(url, "the group is no IPv4 address");
  if ((address.group >> 28) != 0xE)
    refuse(url, "the group is not a multicast address (224.0.0.0 to 239.255.255.255)");
  if (colon != std::string_view::npos) {
    std::uint32_t port = 0;
    if (!parse_number(rest.substr(colon + 1), 65535, port) || port == 0)
      refuse(url, "the port is not in 1..65535");
    address.port = static_cast<std::uint16_t>(port);
  }
  while (!options.empty()) {
    const std::size_t next = options.find('&');
    const std::string_view option = options.substr(0, next);
    options.remove_prefix(next == std::string_view::npos ? options.size() : next + 1);
    constexpr std::string_view kTtl = "ttl=";
    constexpr std::string_view kBuffer = "recv_buf_size=";
    std::uint32_t value = 0;
    if (option.starts_with(kTtl)) {
      if (!parse_number(option.substr(kTtl.size()), 255, value)) refuse(url, "ttl is not in 0..255");
    } else if (option.starts_with(kBuffer)) {
      if (!parse_number(option.substr(kBuffer.size()), kMaxBuffer, value))
        refuse(url, "recv_buf_size is no number");
      address.receive_buffer = value;
    } else {
      refuse(url, "unknown option (known: ttl, recv_buf_size)");
    }
  }
  return address;
}

}  // namespace sortie::drivers
