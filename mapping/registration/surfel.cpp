// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/surfel.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/symmetric_eigen.hpp"

namespace sortie::mapping {
namespace {
constexpr std::int64_t kHalf = kSurfelSteps / 2;

bool within(std::int64_t value, std::int64_t most) { return value >= -most && value <= most; }

bool can_be(const SurfelSums& sums) {
  const auto count = std::int64_t{sums.count};
  for (int i = 0; i < 3; ++i) {
    if (!within(sums.sum[i], kHalf * count)) return false;
    if (sums.product[i] < 0 || !within(sums.product[i], kHalf * kHalf * count)) return false;
    if (!within(sums.product[3 + i], kHalf * kHalf * count)) return false;
  }
  return true;
}

bool is_finite(const Surfel& surfel) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(surfel.variance_m2[i]) || !rt::is_finite(surfel.along(i))) return false;
  }
  return rt::is_finite(surfel.mean());
}

bool can_be(const Surfel& surfel, double cell_m) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::fabs(static_cast<double>(surfel.mean_m[i])) <= 0.5001 * cell_m)) return false;
    if (!(surfel.variance(i) >= 0.0 && surfel.variance(i) <= cell_m * cell_m)) return false;
    const double square = rt::dot(surfel.along(i), surfel.along(i));
    if (!(square > 0.99 && square < 1.01)) return false;
  }
  return true;
}
}  // namespace

void SurfelSums::fade() {
  if (count == 0) return;
  const std::uint32_t half = count / 2;
  for (std::int64_t& part : product) part = part * half / count;  // below 2^37 * 2^14
  for (std::int32_t& part : sum) part = static_cast<std::int32_t>(std::int64_t{part} * half / count);
  count = half;
}

SurfelSums widened(SurfelSums sums, const bool (&upper)[3]) {
  while (sums.count > kMostSurfelPoints / 8) sums.fade();
  const auto n = static_cast<std::int64_t>(sums.count);
  if (n == 0) return sums;
  std::int64_t off[3];   // of this cell's middle from the wider one's, in this one's steps
  std::int64_t from[3];  // sums from the wider one's middle
  std::int64_t odd[3];   // half a step of the wider one that its sums have no room for
  SurfelSums wide;
  wide.count = sums.count;
  for (int i = 0; i < 3; ++i) {
    off[i] = upper[i] ? kSurfelSteps / 2 : -kSurfelSteps / 2;
    from[i] = sums.sum[i] + n * off[i];
    odd[i] = from[i] & 1;
    wide.sum[i] = static_cast<std::int32_t>(from[i] >> 1);
  }
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = kPairs[k];
    const std::int64_t product =
        sums.product[k] + off[i] * sums.sum[j] + off[j] * sums.sum[i] + n * off[i] * off[j];
    // As if all points moved by what the sums lost: the covariance stays what it was.
    wide.product[k] = (product - (odd[i] * from[j] + odd[j] * from[i]) / n) / 4;
  }
  return wide;
}

Surfel surfel_of(const SurfelSums& sums, double cell_m, bool planar) {
  const auto n = static_cast<std::int64_t>(sums.count);
  const double step = cell_m / kSurfelSteps;
  const double scale = step * step / (static_cast<double>(n) * static_cast<double>(n));
  // n times the products minus the products of the sums: whole numbers below 2^54, so nothing cancels.
  const auto part = [&](int at, int i, int k) {
    return scale *
           static_cast<double>(n * sums.product[at] - std::int64_t{sums.sum[i]} * std::int64_t{sums.sum[k]});
  };
  Symmetric3 variance{part(0, 0, 0), part(1, 1, 1), part(2, 2, 2),
                      part(3, 0, 1), part(4, 0, 2), part(5, 1, 2)};
  if (planar) {
    variance.zz = cell_m * cell_m / 12.0;
    variance.xz = variance.yz = 0.0;
  }
  const SymmetricEigen eigen = symmetric_eigen(variance);
  Surfel surfel;
  surfel.count = sums.count;
  for (int i = 0; i < 3; ++i) {
    surfel.mean_m[i] = static_cast<float>(step * sums.sum[i] / static_cast<double>(n));
    surfel.variance_m2[i] = static_cast<float>(std::max(0.0, eigen.value[i]));
    for (int j = 0; j < 3; ++j) surfel.axis[i][j] = static_cast<float>(eigen.vector[i][j]);
  }
  return surfel;
}

const char* fault_of(const SurfelRecord& record, double cell_m, bool sides) {
  if (sides ? record.key == ~std::uint64_t{0} : (record.key & SurfelRecord::kOtherSide) != 0)
    return "no cell has this key";
  if (record.sums.count == 0) return "a surfel without points";
  if (record.sums.count > kMostSurfelPoints) return "a surfel of more points than its sums have room for";
  if (!can_be(record.sums)) return "sums that no points in a cell have";
  if (!is_finite(record.surfel)) return "a Gaussian that is not finite";
  if (record.surfel.count > record.sums.count) return "a Gaussian of more points than its cell has";
  if (record.surfel.count > 0 && !can_be(record.surfel, cell_m)) return "a Gaussian that lies in no cell";
  return nullptr;
}

}  // namespace sortie::mapping
