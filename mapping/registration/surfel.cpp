// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/surfel.hpp"

#include <algorithm>

#include "mapping/registration/symmetric_eigen.hpp"

namespace sortie::mapping {

void SurfelSums::fade() {
  if (count == 0) return;
  const std::uint32_t half = count / 2;
  for (std::int64_t& part : product) part = part * half / count;  // below 2^37 * 2^14
  for (std::int32_t& part : sum) part = static_cast<std::int32_t>(std::int64_t{part} * half / count);
  count = half;
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

}  // namespace sortie::mapping
