// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/scan_sample.hpp"

#include <bit>
#include <cmath>

#include "mapping/grid/mix64.hpp"

namespace sortie::mapping {
namespace {
constexpr double kShift = 1 << 20;  ///< makes whole coordinates positive: beyond any range of a lidar
constexpr std::size_t kStride = 0x9e3779b1u;  ///< odd: visits every slot of a table of 2^n once

std::uint64_t whole(double u) { return static_cast<std::uint64_t>(u + kShift); }

/// A number that a return's bits decide, evenly spread.
std::uint64_t rank_of(const rt::ScanPoint& p) {
  return mix64(
      mix64(std::bit_cast<std::uint32_t>(p.x_m) | std::uint64_t{std::bit_cast<std::uint32_t>(p.y_m)} << 32) ^
      std::bit_cast<std::uint32_t>(p.z_m));
}

}  // namespace

std::size_t ScanSample::choose(std::span<const rt::ScanPoint> scan, std::span<SamplePoint> out,
                               ScanSampleCounts& counts) {
  ++scan_;
  const std::size_t mask = slots_.size() - 1;
  std::uint64_t good = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const rt::ScanPoint& p = scan[i];
    const double x = static_cast<double>(p.x_m);
    const double y = static_cast<double>(p.y_m);
    const double z = static_cast<double>(p.z_m);
    const double range2 = x * x + y * y + z * z;
    ++counts.in;
    if (!std::isfinite(range2)) {
      ++counts.not_finite;
    } else if (range2 < min2_) {
      ++counts.too_near;
    } else if (range2 > max2_) {
      ++counts.too_far;
    } else {
      ++good;
      const std::uint64_t cube =
          whole(x * per_edge_) | whole(y * per_edge_) << 21 | whole(z * per_edge_) << 42;
      Slot& slot = slots_[static_cast<std::size_t>(mix64(cube)) & mask];
      // Two returns with the same bits are one and the same.
      const std::uint64_t rank = rank_of(p);
      if (slot.scan == scan_ && slot.rank <= rank) continue;
      slot = {rank, static_cast<std::uint32_t>(i), scan_};
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0, at = 0; i < slots_.size() && kept < out.size(); ++i, at = (at + kStride) & mask) {
    const Slot& slot = slots_[at];
    if (slot.scan != scan_) continue;
    const rt::ScanPoint& p = scan[slot.index];
    out[kept++] = {p.x_m, p.y_m, p.z_m};
  }
  counts.kept += kept;
  counts.thinned += good - kept;
  return kept;
}

}  // namespace sortie::mapping
