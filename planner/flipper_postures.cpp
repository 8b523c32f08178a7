// SPDX-License-Identifier: BSD-3-Clause
#include "planner/flipper_postures.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::planner {
namespace {
constexpr double kLongestStep_s = 0.2;  // after a pause the angles go on as if it had been this long
}

Status FlipperPostures::set_up(std::span<const FlipperPosture> postures, const FlipperConfig& config) {
  if (postures.empty()) return Status::empty;
  if (postures.size() > kMaxPostures) return Status::full;
  for (const FlipperPosture& posture : postures) {
    for (const double angle : posture.angle_rad) {
      if (!std::isfinite(angle)) return Status::not_finite;
    }
  }
  if (config.initial >= postures.size() || !(config.rate_rad_s > 0.0)) return Status::out_of_range;
  config_ = config;
  std::copy(postures.begin(), postures.end(), postures_.begin());
  size_ = static_cast<std::uint32_t>(postures.size());
  output_ = {};
  output_.posture = static_cast<std::int32_t>(config.initial);
  std::copy(std::begin(postures[config.initial].angle_rad), std::end(postures[config.initial].angle_rad),
            output_.angle_rad);
  return Status::ok;
}

Status FlipperPostures::observe(const rt::FlipperSample& sample) {
  for (const double angle : sample.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  std::copy(std::begin(sample.angle_rad), std::end(sample.angle_rad), output_.measured_rad);
  if ((output_.flags & kFlippersMeasured) == 0 && !started_)
    std::copy(std::begin(sample.angle_rad), std::end(sample.angle_rad), output_.angle_rad);
  output_.flags |= kFlippersMeasured;
  return Status::ok;
}

Status FlipperPostures::update(std::int32_t wanted, bool hold, rt::Nanoseconds now_ns) {
  if (started_ && now_ns == output_.stamp_ns) return Status::time_repeated;
  if (started_ && now_ns < output_.stamp_ns) return Status::time_backwards;
  const double dt_s = started_ ? std::min(kLongestStep_s, rt::to_seconds(now_ns - output_.stamp_ns)) : 0.0;
  started_ = true;
  output_.stamp_ns = now_ns;
  const bool exists = wanted >= -1 && wanted < size();
  if (!exists) ++output_.refused;
  if (exists && wanted >= 0) output_.posture = wanted;
  const double* goal = postures_[static_cast<std::uint32_t>(output_.posture)].angle_rad;
  double longest = 0.0;
  double off = 0.0;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i)
    longest = std::max(longest, std::fabs(goal[i] - output_.angle_rad[i]));
  const double most = hold ? 0.0 : config_.rate_rad_s * dt_s;
  const bool arrives = longest <= most;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    const double way = goal[i] - output_.angle_rad[i];
    output_.angle_rad[i] = arrives ? goal[i] : output_.angle_rad[i] + way * (most / longest);
    off = std::max(off, std::fabs(goal[i] - output_.measured_rad[i]));
  }
  const std::uint32_t measured = output_.flags & kFlippersMeasured;
  output_.flags = measured | kFlippersEnabled | (hold ? kFlippersHeld : 0u);
  if (arrives) output_.flags |= kFlippersArrived;
  if (arrives && measured != 0 && off <= config_.tolerance_rad) output_.flags |= kFlippersThere;
  return exists ? Status::ok : Status::out_of_range;
}

}  // namespace sortie::planner
