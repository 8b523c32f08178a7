// SPDX-License-Identifier: BSD-3-Clause
// What a network can send to a robot that listens: many datagrams, random ones and damaged requests.
#pragma once

#include <cstdint>
#include <string>

namespace sortie::hil {

/// Where to, and how many.
struct StormConfig {
  std::string url;  ///< "udpm://group:port"
  std::uint32_t datagrams{};
  std::uint32_t per_ms{50};
  std::uint64_t seed{1};
};

/// Sends noise, LCM messages of unknown channels, fragments and requests with wrong tags and changed bytes, a
/// fifth of each, and prints one JSON object: datagrams, refused (by the system). Exit code 0 when all went
/// out.
int storm(const StormConfig& config);

}  // namespace sortie::hil
