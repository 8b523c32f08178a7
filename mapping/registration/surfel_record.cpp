// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/surfel_record.hpp"

#include <cmath>

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
    if (!std::isfinite(surfel.mean_m[i]) || !std::isfinite(surfel.variance_m2[i])) return false;
    for (const float part : surfel.axis[i]) {
      if (!std::isfinite(part)) return false;
    }
  }
  return true;
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

const char* fault_of(const SurfelRecord& record, double cell_m) {
  if (record.key >> 63 != 0) return "no cell has this key";
  if (record.sums.count == 0) return "a surfel without points";
  if (record.sums.count > kMostSurfelPoints) return "a surfel of more points than its sums have room for";
  if (!can_be(record.sums)) return "sums that no points in a cell have";
  if (!is_finite(record.surfel)) return "a Gaussian that is not finite";
  if (record.surfel.count > record.sums.count) return "a Gaussian of more points than its cell has";
  if (record.surfel.count > 0 && !can_be(record.surfel, cell_m)) return "a Gaussian that lies in no cell";
  return nullptr;
}

}  // namespace sortie::mapping
