// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/segment_shape.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/symmetric_eigen.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kShapeStepsOfCell = 256.0;
constexpr double kLog2 = 0.69314718055994530942;
constexpr double kSizeSteps = 8.0;  ///< of a square, to a factor of two: 16 of a length
constexpr double kFillSteps = 8.0;
constexpr double kFull = 240.0;    ///< fill of a solid box; a ball has one step more
constexpr double kUpright = 64.0;  ///< steps of 1
constexpr double kThirdMiddle = 128.0;
constexpr double kThirdSteps = 64.0;
constexpr double kClearFrom = 0.125;  ///< relative gap of two spreads' squares from which their axes count
constexpr double kClearBy = 0.25;     ///< and by how much more they count in full

double log2(double x) { return rt::log(x) / kLog2; }

std::uint8_t to_step(double value) {
  return static_cast<std::uint8_t>(rt::floor(std::clamp(value, 0.0, 255.0) + 0.5));
}

/// Nearest whole number to a / n, halves up: moves with a by whole multiples of n.
std::int64_t nearest(std::int64_t a, std::int64_t n) {
  const std::int64_t twice = 2 * a + n;
  const std::int64_t cut = twice / (2 * n);
  return twice < 0 && cut * 2 * n != twice ? cut - 1 : cut;
}

/// Covariance of the voxels, square steps, from sums about `middle`: these are small wherever the segment is.
Symmetric3 covariance_of(const SegmentMoments& m, SegmentFrame& frame) {
  const double n = static_cast<double>(m.count);
  std::int64_t middle[3], sum[3];
  for (int i = 0; i < 3; ++i) {
    middle[i] = nearest(m.sum[i], m.count);
    sum[i] = m.sum[i] - m.count * middle[i];
    frame.middle[i] = static_cast<std::int32_t>(middle[i]);
    frame.rest[i] = static_cast<double>(sum[i]) / n;
  }
  const auto of = [&](std::int64_t about_corner, int i, int k) {
    const std::int64_t about =
        about_corner - middle[i] * m.sum[k] - middle[k] * m.sum[i] + m.count * middle[i] * middle[k];
    return static_cast<double>(about) / n - frame.rest[i] * frame.rest[k];
  };
  return {of(m.square[0], 0, 0),  of(m.square[1], 1, 1),  of(m.square[2], 2, 2),
          of(m.product[0], 0, 1), of(m.product[1], 0, 2), of(m.product[2], 1, 2)};
}

/// How clear it is that the larger of two squares is the larger one.
double gap(double larger, double smaller, double least) {
  return std::clamp(((larger - smaller) / (larger + least) - kClearFrom) / kClearBy, 0.0, 1.0);
}

/// Shares a voxel between the bins left and right of `at`, in 1/256 of a bin from the middle of the first.
void share(std::uint32_t (&bins)[SegmentDescriptor::kBins], double at) {
  constexpr std::int32_t kLast = SegmentDescriptor::kBins - 1;
  const auto place = static_cast<std::int32_t>(std::clamp(at, 0.0, 1.0 * kLast * SegmentShape::kBin) + 0.5);
  const std::int32_t bin = std::min(place / SegmentShape::kBin, kLast - 1);
  const std::int32_t right = place - bin * SegmentShape::kBin;
  bins[bin] += static_cast<std::uint32_t>(SegmentShape::kBin - right);
  bins[bin + 1] += static_cast<std::uint32_t>(right);
}

}  // namespace

SegmentFrame frame_of(const SegmentMoments& m, double voxel_size_m) {
  SegmentFrame frame;
  if (m.count <= 0) return frame;
  const Symmetric3 covariance = covariance_of(m, frame);
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  const double least_steps = kLeastSpread_m * kShapeStepsOfCell / voxel_size_m;
  const double least = least_steps * least_steps;
  double l[3], box = 1.0;
  for (int i = 0; i < 3; ++i) {
    l[i] = std::max(eigen.value[2 - i], 0.0);
    frame.size[i] = to_step(kSizeSteps * log2(1.0 + l[i] / least));
    // Of n cells in a row, the variance is (n^2 - 1) / 12.
    box *= std::sqrt(12.0 * l[i] / (kShapeStepsOfCell * kShapeStepsOfCell) + 1.0);
  }
  frame.fill = to_step(kFull + kFillSteps * log2(static_cast<double>(m.count) / box));
  frame.certain[0] = gap(l[0], l[1], least);
  frame.certain[1] = std::min(frame.certain[0], gap(l[1], l[2], least));
  for (int k = 0; k < 2; ++k) {
    const double(&axis)[3] = eigen.vector[2 - k];
    const double spread = std::sqrt(l[k] + least);
    for (int i = 0; i < 3; ++i) frame.axis[k][i] = axis[i] / spread;
    frame.upright[k] = std::min(std::fabs(axis[2]), 1.0);
  }
  frame.per_height = 1.0 / std::sqrt(std::max(covariance.zz, 0.0) + least);
  frame.per_radius = 1.0 / std::sqrt(std::max(covariance.xx + covariance.yy, 0.0) + least);
  return frame;
}

void SegmentShape::add(const SegmentFrame& frame, const std::int32_t (&at)[3]) {
  double d[3];
  for (int i = 0; i < 3; ++i) d[i] = static_cast<double>(at[i] - frame.middle[i]) - frame.rest[i];
  for (int k = 0; k < 2; ++k) {
    const double along = d[0] * frame.axis[k][0] + d[1] * frame.axis[k][1] + d[2] * frame.axis[k][2];
    // Lifted above 0, where cutting off rounds down.
    const double lifted = std::clamp(kUnit * along, -1.0 * kMost, 1.0 * kMost) + (kMost + 0.5);
    const std::int64_t t = static_cast<std::int32_t>(lifted) - kMost;
    cube[k] += t * t * t;
  }
  constexpr double kAcross = (SegmentDescriptor::kBins - 1) * kBin;
  share(height, (d[2] * frame.per_height + 2.0) * (kAcross / 4.0));
  share(radius, std::sqrt(d[0] * d[0] + d[1] * d[1]) * frame.per_radius * (kAcross / 2.0));
  ++count;
}

SegmentDescriptor descriptor_of(const SegmentFrame& frame, const SegmentShape& shape) {
  using D = SegmentDescriptor;
  D descriptor;
  if (shape.count <= 0 || !(frame.per_height > 0.0)) return descriptor;
  const double n = static_cast<double>(shape.count);
  std::copy_n(frame.size, 3, descriptor.step + D::kSize);
  descriptor.step[D::kFill] = frame.fill;
  for (unsigned k = 0; k < 2; ++k) {
    descriptor.step[D::kUpright + k] = to_step(kUpright * frame.certain[k] * frame.upright[k]);
    // symmetric_eigen() has the axes point up; where they are level that is chance, and the sign fades.
    const double third = static_cast<double>(shape.cube[k]) /
                         (n * SegmentShape::kUnit * SegmentShape::kUnit * SegmentShape::kUnit);
    const double said = third * frame.upright[k] + std::fabs(third) * (1.0 - frame.upright[k]);
    descriptor.step[D::kThird + k] = to_step(kThirdMiddle + kThirdSteps * frame.certain[k] * said);
  }
  const auto part = [&shape](std::uint32_t bin) {  // of 128, to the nearest
    const auto voxels = static_cast<std::uint64_t>(shape.count);
    return static_cast<std::uint8_t>((bin + voxels) / (2 * voxels));
  };
  for (unsigned b = 0; b < D::kBins; ++b) {
    descriptor.step[D::kHeight + b] = part(shape.height[b]);
    descriptor.step[D::kRadius + b] = part(shape.radius[b]);
  }
  return descriptor;
}

}  // namespace sortie::mapping
