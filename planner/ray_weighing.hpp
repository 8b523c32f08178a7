// SPDX-License-Identifier: BSD-3-Clause
// What a whole plan of rays is worth.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "planner/ray_config.hpp"
#include "planner/ray_cover.hpp"
#include "planner/ray_looks.hpp"

namespace sortie::planner {

/// What is known of a plan's worth.
struct RayBounds {
  double lower{};
  double upper{};
  bool weighed{};

  bool is_exact() const { return !(lower < upper); }
};

/// Each ray's worth beside those before it, the last position first. A ray that the table does not take
/// counts in the upper bound.
class RayWeighing {
 public:
  RayWeighing(const RaySizes& sizes, RayLooks& looks, RayTableUse& use)
      : sizes_(sizes), looks_(looks), use_(use) {}

  void begin() {
    cursor_ = 0;
    bounds_ = {0.0, 0.0, true};
    done_ = false;
  }
  /// One step: what it cost. `rays`: K of each position, traced. The cover was empty, and holds the plan, or
  /// what the table took of it, afterwards.
  std::uint32_t step(std::span<const std::uint16_t> rays, RayCover& cover) {
    const std::uint32_t i = cursor_++;
    if (i >= looks_.positions() * sizes_.per_position) {
      done_ = true;
      return 1;
    }
    const std::uint32_t position = looks_.positions() - 1 - i / sizes_.per_position;
    if (position == 0 && i % sizes_.per_position == 0) rest_upper_ = bounds_.upper;
    if (!looks_.is_inside(position)) return 1;
    RayWorth worth;
    bool entered{};
    const std::uint32_t ray =
        position * sizes_.all_rays + rays[position * sizes_.per_position + i % sizes_.per_position];
    const std::uint32_t cost = looks_.enter(ray, cover, worth, entered);
    if (entered) bounds_.lower += worth.current;
    bounds_.upper += worth.current;
    use_.refused = use_.refused || !entered;
    use_.most_lines = std::max(use_.most_lines, cover.table().used());
    return cost;
  }
  bool done() const { return done_; }
  const RayBounds& bounds() const { return bounds_; }
  /// The upper bound of the plan without its first position.
  double rest_upper() const { return rest_upper_; }

 private:
  const RaySizes& sizes_;
  RayLooks& looks_;
  RayTableUse& use_;
  RayBounds bounds_;
  double rest_upper_{};
  std::uint32_t cursor_{};
  bool done_{};
};

}  // namespace sortie::planner
