// SPDX-License-Identifier: BSD-3-Clause
// Messages of a solid-state lidar. encode() and decode() are those of wire_fields.hpp; no heap.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/ssl_port.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/ssl_samples.hpp"

namespace sortie::drivers {

/// ssl_command_t and ssl_returns_t: an array is as long as there are rays.
struct SslRules : WireNumbered {
  static constexpr void members(auto& self, auto&& visit) {
    const auto of_rays = [&self](auto& array) {
      return counted("n", std::span(array), self.rays, Status::malformed);
    };
    visit("stamp_ns", self.stamp_ns);
    visit("number", self.number);
    visit("n", self.rays);
    visit("direction", of_rays(self.direction));
    if constexpr (requires { self.range_mm; }) {
      visit("range_mm", of_rays(self.range_mm));
      visit("age_10us", of_rays(self.age_10us));
    }
  }
  static bool taken(const auto& sample) { return can_be_fired(sample); }
  static bool sent(const auto& sample) { return can_be_fired(sample); }
};
template <>
struct WireRules<rt::SslCommand> : SslRules {};
template <>
struct WireRules<rt::SslReturns> : SslRules {};

/// Sizes of the largest messages in bytes, fingerprint included.
inline constexpr std::size_t kSslCommandBytes = kLeastBytes<rt::SslCommand> + 2 * rt::kSslMaxRays;
inline constexpr std::size_t kSslReturnsBytes = kLeastBytes<rt::SslReturns> + 3 * 2 * rt::kSslMaxRays;

}  // namespace sortie::drivers
