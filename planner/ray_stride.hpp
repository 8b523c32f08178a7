// SPDX-License-Identifier: BSD-3-Clause
// Rays for a solid-state lidar without a map: strides through the grid of directions that visit each once.
#pragma once

#include <cstdint>

#include "rt/ssl_samples.hpp"

namespace sortie::planner {

/// The golden section of the number of directions, and coprime to it: any K rays in a row are spread over the
/// whole field of view, and after kSslDirections rays each direction was asked for exactly once.
inline constexpr std::uint32_t kRayStride = 11'867;

/// What asks for the next rays where nothing better is known. Plain state, no heap.
class RayStride {
 public:
  /// The next `rays` (at most kSslMaxRays) directions. Commands are numbered from 1. Cost: 1 ns a ray.
  void next(std::uint32_t rays, rt::Nanoseconds stamp_ns, rt::SslCommand& command) {
    command = {};
    command.stamp_ns = stamp_ns;
    command.number = ++number_;
    command.rays = rays < rt::kSslMaxRays ? rays : rt::kSslMaxRays;
    for (std::uint32_t i = 0; i < command.rays; ++i) {
      command.direction[i] = static_cast<std::uint16_t>(direction_);
      direction_ = (direction_ + kRayStride) % rt::kSslDirections;
    }
  }

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("direction", self.direction_);
    visit("number", self.number_);
  }

 private:
  std::uint32_t direction_{};
  std::uint32_t number_{};
};

}  // namespace sortie::planner
