// SPDX-License-Identifier: BSD-3-Clause
// Where the vehicle is on another robot's cloud: what the part `join` puts out.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// Output of task `join`.
struct JoinOutput {
  rt::Nanoseconds stamp_ns{};  ///< of the job
  bool placed{};               ///< for good: T_map_own holds
  double p_map_own_m[3]{};
  double q_map_own[4]{1, 0, 0, 0};
  std::uint8_t verdict{};     ///< mapping::CloudVerdict of the newest match
  std::uint8_t refusal{};     ///< mapping::CloudRefusal of it
  double p_map_match_m[3]{};  ///< its T_map_own, also where it is refused
  double q_map_match[4]{1, 0, 0, 0};
  double scale{1};
  double sigma_m{};
  double sigma_rad{};
  double lead{};
  std::uint32_t cells{};
  std::uint32_t on{};
  std::uint32_t through{};
  std::uint64_t matches{};    ///< that ended
  std::uint64_t accepted{};   ///< of them
  std::uint64_t disagreed{};  ///< places that the next accepted one was not at
  std::uint64_t units{};      ///< of work of all matches
  SORTIE_FIELDS(stamp_ns, placed, p_map_own_m, q_map_own, verdict, refusal, p_map_match_m, q_map_match, scale,
                sigma_m, sigma_rad, lead, cells, on, through, matches, accepted, disagreed, units)
};

}  // namespace sortie::firmware
