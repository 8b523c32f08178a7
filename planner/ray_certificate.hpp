// SPDX-License-Identifier: BSD-3-Clause
// The certificate of a plan of rays.
#pragma once

#include <cstdint>

#include "planner/ray_config.hpp"
#include "planner/ray_cover.hpp"
#include "planner/ray_heap.hpp"
#include "planner/ray_looks.hpp"

namespace sortie::planner {

/// Coverage is monotone and submodular, so for any set S and the best plan O:
///     worth(O) <= worth(S) + sum over positions of the K greatest worths beside S.
/// S is what a cover holds, and that alone: nothing is asked of how it came there or how good it is, and
/// nothing here can change it. All directions are traced before. Old worths bound new ones from above, so
/// only those that come to the top of the heap are computed again.
class RayCertificate {
 public:
  RayCertificate(const RaySizes& sizes, RayHeap& heap, RayLooks& looks)
      : sizes_(sizes), heap_(heap), looks_(looks) {}

  void begin();
  /// One step: what it cost. The cover stays as it is until done().
  std::uint32_t step(const RayCover& cover) { return filled_ ? find_next(cover) : fill_next(cover); }
  bool done() const { return done_; }
  /// No plan is worth more. After done().
  double bound() const { return bound_; }

 private:
  std::uint32_t fill_next(const RayCover& cover);
  std::uint32_t find_next(const RayCover& cover);

  const RaySizes& sizes_;
  RayHeap& heap_;
  RayLooks& looks_;
  std::uint32_t cursor_{};
  std::uint32_t left_{};
  std::uint32_t counts_[RaySizes::kMostPositions]{};
  std::uint64_t tried_{};  // best key that is of this cover
  double sum_{};
  double bound_{};
  bool filled_{};
  bool done_{};
};

}  // namespace sortie::planner
