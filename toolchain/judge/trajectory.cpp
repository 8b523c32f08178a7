// SPDX-License-Identifier: BSD-3-Clause
// Pairing by time with interpolation: the denser trajectory is read at the stamps of the sparser.
#include "toolchain/judge/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sortie::toolchain {
namespace {

/// Spherical interpolation, linear where the arc is so short that sin(arc) would lose digits.
void slerp(const double (&a)[4], const double (&b)[4], double u, double (&out)[4]) {
  double dot = 0.0;
  for (int i = 0; i < 4; ++i) dot += a[i] * b[i];
  const double sign = dot < 0.0 ? -1.0 : 1.0;
  dot = std::min(1.0, std::fabs(dot));
  double wa = 1.0 - u;
  double wb = u;
  if (dot < 0.9999995) {
    const double arc = std::acos(dot);
    wa = std::sin((1.0 - u) * arc) / std::sin(arc);
    wb = std::sin(u * arc) / std::sin(arc);
  }
  for (int i = 0; i < 4; ++i) out[i] = wa * a[i] + sign * wb * b[i];
  firmware::make_unit(out);
}

/// From a to b, which is not earlier. Truth of another's log may have any stamps: no sum of them overflows.
std::int64_t gap_between(const firmware::TimedPose& a, const firmware::TimedPose& b) {
  const auto gap = static_cast<std::uint64_t>(b.stamp_ns) - static_cast<std::uint64_t>(a.stamp_ns);
  return static_cast<std::int64_t>(std::min<std::uint64_t>(gap, std::numeric_limits<std::int64_t>::max()));
}

/// Five median steps, at least 50 ms.
std::int64_t usual_gap(std::span<const firmware::TimedPose> trajectory) {
  constexpr std::int64_t kLeast = 50'000'000;
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 5;
  if (trajectory.size() < 2) return kLeast;
  std::vector<std::int64_t> steps;
  steps.reserve(trajectory.size());
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    steps.push_back(std::min(gap_between(trajectory[i - 1], trajectory[i]), kMost));
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::max(kLeast, 5 * *middle);
}

/// How many samples of `a` lie in the span of `b`: the density of each is judged over the common time only.
std::size_t count_within(std::span<const firmware::TimedPose> a, std::span<const firmware::TimedPose> b) {
  if (b.empty()) return 0;
  return static_cast<std::size_t>(std::count_if(a.begin(), a.end(), [&](const firmware::TimedPose& pose) {
    return pose.stamp_ns >= b.front().stamp_ns && pose.stamp_ns <= b.back().stamp_ns;
  }));
}

}  // namespace

bool interpolate(std::span<const firmware::TimedPose> trajectory, std::int64_t stamp_ns,
                 std::int64_t max_gap_ns, firmware::TimedPose& pose) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                       [](const firmware::TimedPose& p, std::int64_t stamp) { return p.stamp_ns < stamp; });
  if (after == trajectory.end()) return false;
  if (after->stamp_ns == stamp_ns) {
    pose = *after;
    return true;
  }
  if (after == trajectory.begin()) return false;
  const firmware::TimedPose& a = *(after - 1);
  const firmware::TimedPose& b = *after;
  if (gap_between(a, b) > max_gap_ns) return false;
  const double u = static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  pose.stamp_ns = stamp_ns;
  for (int i = 0; i < 3; ++i) pose.p[i] = a.p[i] + u * (b.p[i] - a.p[i]);
  slerp(a.q, b.q, u, pose.q);
  pose.flags = a.flags & b.flags;
  return true;
}

PairedTrajectories associate(std::span<const firmware::TimedPose> estimate,
                             std::span<const firmware::TimedPose> truth) {
  PairedTrajectories pairs;
  const bool at_truth = count_within(truth, estimate) <= count_within(estimate, truth);
  const auto& sparse = at_truth ? truth : estimate;
  const auto& dense = at_truth ? estimate : truth;
  const std::int64_t gap = usual_gap(dense);
  pairs.estimate.reserve(sparse.size());
  pairs.truth.reserve(sparse.size());
  for (const firmware::TimedPose& own : sparse) {
    firmware::TimedPose other;
    if (!interpolate(dense, own.stamp_ns, gap, other)) {
      ++pairs.skipped;
      continue;
    }
    pairs.estimate.push_back(at_truth ? other : own);
    pairs.truth.push_back(at_truth ? own : other);
    // What the estimate does not claim is not judged: an attitude alone has no position error.
    constexpr std::uint32_t kParts = rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation;
    pairs.truth.back().flags &= pairs.estimate.back().flags | ~kParts;
  }
  return pairs;
}

}  // namespace sortie::toolchain
