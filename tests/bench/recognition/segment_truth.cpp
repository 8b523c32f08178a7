// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/segment_truth.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace sortie::bench {
namespace {

constexpr double kNear_m = 0.2;
constexpr double kSame = 0.5;
constexpr double kDifferent = 0.1;

struct OwnedVoxel {
  rt::Vector3 at;
  std::size_t segment;
};
using VoxelCells = std::unordered_map<std::int64_t, std::vector<OwnedVoxel>>;

std::int64_t cell_key(double x, double y, double z) {
  const auto part = [](double v) { return static_cast<std::int64_t>(std::floor(v / kNear_m)) + (1 << 19); };
  return part(x) | part(y) << 20 | part(z) << 40;
}

/// Of every segment of `own`, the share of its voxels that lie where each one of `others` is; row by row.
std::vector<double> shares(const std::vector<SpokenSegment>& own, const std::vector<SpokenSegment>& others) {
  VoxelCells cells;
  for (std::size_t i = 0; i < others.size(); ++i) {
    for (const rt::Vector3& p : others[i].voxels) cells[cell_key(p.x, p.y, p.z)].push_back({p, i});
  }
  std::vector<double> share(own.size() * others.size(), 0.0);
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const double part = 1.0 / static_cast<double>(own[i].voxels.size());
    for (const rt::Vector3& p : own[i].voxels) {
      seen.clear();
      for (int step = 0; step < 27; ++step) {
        const auto found =
            cells.find(cell_key(p.x + kNear_m * (step % 3 - 1), p.y + kNear_m * (step / 3 % 3 - 1),
                                p.z + kNear_m * (step / 9 - 1)));
        if (found == cells.end()) continue;
        for (const OwnedVoxel& other : found->second) {
          if (rt::norm(other.at - p) <= kNear_m) seen.push_back(other.segment);
        }
      }
      std::sort(seen.begin(), seen.end());
      seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
      for (const std::size_t other : seen) share[i * others.size() + other] += part;
    }
  }
  return share;
}
}  // namespace

std::vector<SegmentTruth> true_pairs(const std::vector<SpokenSegment>& first,
                                     const std::vector<SpokenSegment>& second) {
  const std::vector<double> ahead = shares(first, second), back = shares(second, first);
  std::vector<SegmentTruth> truth(ahead.size(), SegmentTruth::between);
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t k = 0; k < second.size(); ++k) {
      const double a = ahead[i * second.size() + k], b = back[k * first.size() + i];
      SegmentTruth& pair = truth[i * second.size() + k];
      if (std::min(a, b) >= kSame) pair = SegmentTruth::same;
      if (std::max(a, b) < kDifferent) pair = SegmentTruth::different;
    }
  }
  return truth;
}

}  // namespace sortie::bench
