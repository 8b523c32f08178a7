// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/elevation/elevation_cell.hpp"

#include <algorithm>

#include "mapping/elevation/elevation_units.hpp"

namespace sortie::mapping {

namespace {

// Square of three standard deviations of the unit weight, in squared height units.
constexpr std::int64_t kNineVariances =
    static_cast<std::int64_t>(9.0 * kUnitWeightVariance_m2 * kHeightUnits * kHeightUnits);

struct Surface {
  std::int32_t height;
  std::uint16_t weight;
  std::uint8_t flags;
};

Surface surface_of(const ElevationCell& cell, std::uint32_t i) {
  return {cell.height[i], cell.weight[i], cell.flags[i]};
}

void put(ElevationCell& cell, std::uint32_t i, const Surface& surface) {
  cell.height[i] = surface.height;
  cell.weight[i] = surface.weight;
  cell.flags[i] = surface.flags;
}

// The weighted mean. |a - b| fits in 32 bits, weights in 16: the product needs 64.
Surface mean(const Surface& a, const Surface& b, std::uint16_t most_weight) {
  const std::int64_t sum = std::int64_t{a.weight} + b.weight;
  const std::int64_t apart = std::int64_t{b.height} - a.height;
  const std::int64_t step = divide_nearest<std::int64_t>(b.weight * apart, sum);
  return {static_cast<std::int32_t>(a.height + step),
          static_cast<std::uint16_t>(std::min<std::int64_t>(sum, most_weight)),
          static_cast<std::uint8_t>(a.flags | b.flags)};
}

// One where two were. A ceiling is as low as its lowest part; of other surfaces the mean.
Surface united(const Surface& low, const Surface& high, std::uint16_t most_weight) {
  Surface one = mean(low, high, most_weight);
  if ((one.flags & ~kFilled) == kSeenFromBelow) one.height = low.height;
  return one;
}

// The same of two that do not belong together: something may be anywhere between them.
Surface filled(const Surface& low, const Surface& high, std::uint16_t most_weight) {
  Surface one = united(low, high, most_weight);
  const std::int64_t apart = std::int64_t{high.height} - low.height;
  const std::int64_t of_spread = 4 * (kNineVariances / 9) / std::max<std::int64_t>(1, apart * apart);
  one.weight = static_cast<std::uint16_t>(std::clamp<std::int64_t>(of_spread, 1, one.weight));
  one.flags |= kFilled;
  return one;
}

// The variance of a difference is the sum of both: its inverse is the product of the weights over their sum.
bool joins(std::int64_t apart, std::int64_t weight, std::int64_t of_return, const SurfaceRule& rule) {
  if (apart <= rule.join) return true;
  if (apart > rule.most_join) return false;
  return apart * apart * (weight * of_return / (weight + of_return)) <= kNineVariances;
}

void remove(ElevationCell& cell, std::uint32_t i) {
  for (; i + 1 < ElevationCell::kSurfaces; ++i) put(cell, i, surface_of(cell, i + 1));
  put(cell, ElevationCell::kSurfaces - 1, {});
}

// Surface i has moved: it takes in a neighbour that is closer than half of `join`.
bool unite_close(ElevationCell& cell, std::uint32_t i, const SurfaceRule& rule) {
  const auto close = [&](std::uint32_t low) {
    return low + 1 < ElevationCell::kSurfaces && cell.weight[low + 1] != 0 &&
           std::int64_t{cell.height[low + 1]} - cell.height[low] <= rule.join / 2;
  };
  std::uint32_t low = i;
  if (!close(low)) {
    if (i == 0 || !close(i - 1)) return false;
    low = i - 1;
  }
  put(cell, low, united(surface_of(cell, low), surface_of(cell, low + 1), rule.most_weight));
  remove(cell, low + 1);
  return true;
}

// Five surfaces in order become four.
void unite_five(ElevationCell& cell, const Surface (&five)[ElevationCell::kSurfaces + 1],
                std::uint16_t most_weight) {
  constexpr std::uint32_t kPairs = ElevationCell::kSurfaces;
  // Another kind is worse than an outer pair, that is worse than any gap.
  constexpr std::int64_t kOuter = std::int64_t{1} << 33;
  constexpr std::int64_t kOther = std::int64_t{1} << 34;
  std::uint32_t best = 0;
  std::int64_t least = INT64_MAX;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    std::int64_t price = std::int64_t{five[i + 1].height} - five[i].height;
    if (i == 0 || i + 1 == kPairs) price += kOuter;
    if (((five[i].flags ^ five[i + 1].flags) & ~kFilled) != 0) price += kOther;
    if (price >= least) continue;
    least = price;
    best = i;
  }
  Surface one = filled(five[best], five[best + 1], most_weight);
  // The foot and the top of what was seen stay where they are.
  if (best == 0) one.height = five[0].height;
  if (best + 1 == kPairs) one.height = five[kPairs].height;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    if (i == best) {
      put(cell, i, one);
    } else {
      put(cell, i, five[i < best ? i : i + 1]);
    }
  }
}

}  // namespace

void age(ElevationCell& cell, std::uint32_t variance) {
  if (variance == cell.variance) return;
  for (std::uint16_t& weight : cell.weight) weight = aged_weight(weight, cell.variance, variance);
  cell.variance = variance;
}

SurfaceChange take_height(ElevationCell& cell, std::int32_t height, std::uint16_t weight, std::uint8_t flags,
                          const SurfaceRule& rule) {
  const std::uint32_t n = cell.surfaces();
  std::uint32_t nearest = 0;
  std::uint32_t below = 0;  // surfaces that lie lower than the new one
  std::int64_t least = INT64_MAX;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::int64_t apart = std::int64_t{height} - cell.height[i];
    if (apart > 0) below = i + 1;
    const std::int64_t size = apart < 0 ? -apart : apart;
    if (size >= least) continue;
    least = size;
    nearest = i;
  }
  const Surface fresh{height, std::min(weight, rule.most_weight), flags};
  if (n > 0 && joins(least, cell.weight[nearest], fresh.weight, rule)) {
    const std::int32_t before = cell.height[nearest];
    put(cell, nearest, mean(surface_of(cell, nearest), fresh, rule.most_weight));
    // One that stands for several takes in what lies far off: as foot or top it does not give way to that.
    if ((cell.flags[nearest] & kFilled) != 0) {
      if (nearest == 0) cell.height[0] = std::min(cell.height[0], before);
      if (nearest + 1 == n) cell.height[nearest] = std::max(cell.height[nearest], before);
    }
    return unite_close(cell, nearest, rule) ? SurfaceChange::merged : SurfaceChange::joined;
  }
  Surface five[ElevationCell::kSurfaces + 1];
  for (std::uint32_t i = 0; i <= n; ++i)
    five[i] = i == below ? fresh : surface_of(cell, i < below ? i : i - 1);
  if (n == ElevationCell::kSurfaces) {
    unite_five(cell, five, rule.most_weight);
    return SurfaceChange::merged;
  }
  for (std::uint32_t i = below; i <= n; ++i) put(cell, i, five[i]);
  return SurfaceChange::added;
}

}  // namespace sortie::mapping
