// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/seen_space.hpp"

#include <algorithm>
#include <limits>

#include "mapping/registration/kept_pose.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kPi = 3.14159265358979323846;
constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr double kClear = 0.3;  ///< m, and a part of the range: by so much a ray must have gone on
constexpr double kClearPart = 0.03;
constexpr int kLeastNeighbours = 5;  ///< of 9 directions that must have seen something
constexpr int kLeastInPlane = 3;     ///< of 3
}  // namespace

/// False right at the sensor.
bool SeenSpace::direction(const rt::Vector3& v, double range_m, int& turn, int& rise) {
  if (!(range_m > 1e-3)) return false;
  turn = static_cast<int>((rt::atan2(v.y, v.x) + kPi) * (kTurns / (2.0 * kPi)));
  rise = static_cast<int>((v.z / range_m + 1.0) * (0.5 * kRises));
  turn = std::clamp(turn, 0, kTurns - 1);
  rise = std::clamp(rise, 0, kRises - 1);
  return true;
}

void SeenSpace::take(std::span<const SamplePoint> sample, const RigidPose& pose) {
  std::fill(ranges_.begin(), ranges_.end(), kNone);
  pose_ = pose;
  some_ = !sample.empty();
  for (const SamplePoint& p : sample) {
    const rt::Vector3 v = p.at();
    const double range = rt::norm(v);
    int turn{};
    int rise{};
    if (!direction(v, range, turn, rise)) continue;
    float& nearest = at(turn, rise);
    nearest = std::min(nearest, static_cast<float>(range));
  }
}

double SeenSpace::share_inside(std::span<const SamplePoint> sample, const RigidPose& pose) const {
  if (!some_ || sample.empty()) return 0.0;
  const rt::RotationMatrix there = rt::to_matrix(rt::conjugate(pose_.q) * pose.q);
  const rt::Vector3 from = rt::rotate_back(pose_.q, pose.p - pose_.p);
  std::uint32_t inside = 0;
  for (const SamplePoint& p : sample) {
    const rt::Vector3 v = there * p.at() + from;
    const double range = rt::norm(v);
    int turn{};
    int rise{};
    if (!direction(v, range, turn, rise)) continue;
    float nearest = kNone;
    int seen = 0;
    for (int up = std::max(0, rise - 1); up <= std::min(kRises - 1, rise + 1); ++up) {
      for (int side = -1; side <= 1; ++side) {
        const float r = at((turn + side + kTurns) % kTurns, up);
        if (r < kNone) ++seen;
        nearest = std::min(nearest, r);
      }
    }
    if (seen >= (planar_ ? kLeastInPlane : kLeastNeighbours) &&
        range < static_cast<double>(nearest) * (1.0 - kClearPart) - kClear)
      ++inside;
  }
  return inside / static_cast<double>(sample.size());
}

void SeenSpace::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "seen space").by_hand(ranges_).fixed(planar_).state(pose_, some_);
  for (float& range : ranges_) archive.value(range);
  check_pose(archive, pose_);
}

}  // namespace sortie::mapping
