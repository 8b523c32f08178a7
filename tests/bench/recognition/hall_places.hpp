// SPDX-License-Identifier: BSD-3-Clause
// Places along the two ways through made-up halls, and what a robot has of each.
#pragma once

#include <functional>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "tests/bench/recognition/thing_hall.hpp"

namespace sortie::bench {

/// What a robot has when it comes to a place.
struct HallPlace {
  std::size_t hall{};
  int visit{};
  SecondWay way{};                  ///< of the hall
  rt::Vector3 at;                   ///< of the sensor, in the hall
  std::vector<rt::Vector3> scan;    ///< the newest one, in the sensor's frame
  std::vector<rt::Vector3> voxels;  ///< of the local map, about the sensor; turned as the map is
  std::vector<mapping::SpeakingSegment> segments;  ///< that speak, the nearest 64
};

/// Drives the halls of `descriptors`, each twice, with local maps of 20 m radius that begin with the visit,
/// and calls `use` with a place for every 3 m of way. The same for the same seed; hall n has seed + n.
void for_places(int halls, std::uint64_t seed, const std::function<void(const HallPlace&)>& use);

}  // namespace sortie::bench
