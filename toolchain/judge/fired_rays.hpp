// SPDX-License-Identifier: BSD-3-Clause
// Where the rays of a solid-state lidar went, from a log's answers and the path that was estimated.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/judge/trajectory.hpp"

namespace sortie::toolchain {

/// One ray, in metres of the world.
struct FiredRay {
  rt::Nanoseconds at_ns{};  ///< when it was fired
  std::uint32_t command{};  ///< number of the command that asked for it
  double from_m[3]{};
  double to_m[3]{};  ///< where it met something, or what it says is free up to
  bool hit{};
};

/// Rays in the order of their commands.
struct FiredRays {
  std::vector<FiredRay> rays;
  std::uint64_t frames{};    ///< answers to a command of the log, newer than those before them
  std::uint64_t unplaced{};  ///< rays that the path says no place for
};

/// The rays of a log's channel SSL, each from where the path says that the sensor was at its own time; of a
/// log of more than a thousand frames each so many-th one and the newest. A ray without a return ends at
/// occupancy.silent_free_m. `profile`: the scene that the log was replayed with. Cost: one look at the path
/// for each ray.
FiredRays fired_rays(const firmware::LogFile& log, firmware::Profile profile,
                     const firmware::Trajectory& path);

}  // namespace sortie::toolchain
