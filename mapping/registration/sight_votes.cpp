// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/sight_votes.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr double kBin_m = 0.25;
constexpr double kFacing = 0.9;  ///< least cosine to the axis
constexpr int kApart = 3;        ///< bins between shifts
}  // namespace

void SightVotes::find(std::span<const SightCell> source, const PlanePose& T_target_source,
                      std::span<const SightCell> target, const rt::Vector3& axis, double cell_ratio,
                      rt::FixedVector<double, kMostSightPeaks>& shifts_m) {
  shifts_m.clear();
  double middle = 0.0;
  for (const SightCell& cell : target)
    middle += rt::dot(axis, cell.mean_m) / static_cast<double>(target.size());
  const auto count = [&](float(&bins)[2][kBins], const rt::Vector3& at, const rt::Vector3& normal,
                         float weight) {
    const double facing = rt::dot(axis, normal);
    const double bin = (rt::dot(axis, at) - middle) / kBin_m + kBins / 2;
    if (std::fabs(facing) > kFacing && bin >= 0.0 && bin < kBins)
      bins[facing > 0.0 ? 1 : 0][static_cast<int>(bin)] += weight;
  };
  for (int side = 0; side < 2; ++side) {
    std::fill_n(source_[side], kBins, 0.0f);
    std::fill_n(target_[side], kBins, 0.0f);
  }
  const rt::RotationMatrix r = rt::to_matrix(T_target_source.q_target_source);
  for (const SightCell& cell : source)
    count(source_, transform(T_target_source, cell.mean_m), r * cell.normal, static_cast<float>(cell_ratio));
  for (const SightCell& cell : target) count(target_, cell.mean_m, cell.normal, 1.0f);
  for (int k = 0; k < kShifts; ++k) {
    const int shift = k - (kBins - 1);
    const int first = std::max(0, -shift);
    const int last = std::min(kBins, kBins - shift);
    float sum = 0.0f;
    for (int side = 0; side < 2; ++side) {
      for (int bin = first; bin < last; ++bin)
        sum += std::min(source_[side][bin], target_[side][bin + shift]);
    }
    sum_[k] = sum;
  }
  while (!shifts_m.full()) {
    int best = -1;
    float most = 0.0f;
    for (int k = 1; k + 1 < kShifts; ++k) {
      const float sum = sum_[k - 1] + sum_[k] + sum_[k + 1];
      if (sum > most && sum_[k] > 0.0f) most = sum, best = k;
    }
    if (best < 0) return;
    const double off = static_cast<double>((sum_[best + 1] - sum_[best - 1]) / most);
    (void)shifts_m.push_back(kBin_m * (best - (kBins - 1) + off));
    std::fill(sum_ + std::max(0, best - kApart), sum_ + std::min(kShifts, best + kApart + 1), 0.0f);
  }
}

}  // namespace sortie::mapping
