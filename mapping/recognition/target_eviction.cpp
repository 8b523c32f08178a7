// SPDX-License-Identifier: BSD-3-Clause
// Which target a full store gives up.
#include <algorithm>
#include <bit>

#include "mapping/grid/mix64.hpp"
#include "mapping/recognition/target_store.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kDrawn = 8;

/// A target that may go. The draw is a bijection of the number: no two are alike.
struct Drawn {
  int seldom{};  ///< views, by the power of two
  std::uint64_t draw{};
  TargetIndex target{};
  PlaceCm place;
  std::int64_t apart2{};

  bool goes_before(const Drawn& other) const {
    return seldom != other.seldom ? seldom < other.seldom : draw < other.draw;
  }
};
}  // namespace

TargetIndex TargetStore::evicted_for(const PlaceCm& place, std::uint32_t stamp_ms) const {
  const std::uint64_t turn = mix64(counts_.evicted + 1);
  Drawn drawn[kDrawn];
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < used_; ++i) {
    const Drawn one{static_cast<int>(std::bit_width(unsigned{records_[i].views})),
                    mix64(turn ^ i),
                    static_cast<TargetIndex>(i),
                    {},
                    0};
    if (count == kDrawn && !one.goes_before(drawn[kDrawn - 1])) continue;
    std::uint32_t at = count < kDrawn ? count++ : kDrawn - 1;
    for (; at > 0 && one.goes_before(drawn[at - 1]); --at) drawn[at] = drawn[at - 1];
    drawn[at] = one;
  }
  // Only those of the fewest views.
  while (drawn[count - 1].seldom != drawn[0].seldom) --count;
  for (std::uint32_t k = 0; k < count; ++k) {
    drawn[k].place = latest_place(records_[drawn[k].target]);
    drawn[k].apart2 = square_apart(drawn[k].place, place);
  }
  for (std::uint32_t i = 0; i < used_; ++i) {
    const PlaceCm other = latest_place(records_[i]);
    for (std::uint32_t k = 0; k < count; ++k) {
      if (drawn[k].target != i)
        drawn[k].apart2 = std::min(drawn[k].apart2, square_apart(drawn[k].place, other));
    }
  }
  const Drawn* least = &drawn[0];
  for (std::uint32_t k = 1; k < count; ++k) {
    const Drawn& one = drawn[k];
    // Ages, since stamps wrap.
    const std::uint32_t age = stamp_ms - records_[one.target].last_seen_ms;
    const std::uint32_t least_age = stamp_ms - records_[least->target].last_seen_ms;
    const bool goes = one.apart2 != least->apart2 ? one.apart2 < least->apart2
                      : age != least_age          ? age > least_age
                                                  : one.target < least->target;
    if (goes) least = &one;
  }
  return least->target;
}

}  // namespace sortie::mapping
