// SPDX-License-Identifier: BSD-3-Clause
// A simulated source of position and heading.
#include "hil/uav/pose_source.hpp"

namespace sortie::hil {

void PoseSource::observe(rt::Nanoseconds now_ns, const MultirotorState& truth) {
  if (now_ns < next_ns_) return;
  next_ns_ += config_.period_ns;
  const double noise_x = random_.normal();
  const double noise_y = random_.normal();
  const double noise_z = random_.normal();
  const double noise_yaw = random_.normal();
  const double lateness = random_.uniform(-1.0, 1.0);
  const bool lost = random_.chance(config_.loss);
  const bool outlier = random_.chance(config_.outlier);
  const double bearing = random_.uniform(0.0, 6.283185307179586);
  const bool dark = now_ns >= dark_from_ns_ && now_ns < dark_to_ns_;
  if (lost || dark || late_.full()) {
    ++lost_;
    return;
  }
  const double off = outlier ? config_.outlier_size_m : 0.0;
  const Quat& q = truth.q_world_body;
  const double yaw = rt::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
  Late late;
  late.arrival_ns = now_ns + config_.delay_ns +
                    static_cast<rt::Nanoseconds>(lateness * static_cast<double>(config_.delay_spread_ns));
  late.fix.stamp_ns = now_ns;
  const double sigma = config_.position_sigma_m;
  late.fix.p_world_m[0] = truth.p_world_m.x + sigma * noise_x + off * rt::cos(bearing);
  late.fix.p_world_m[1] = truth.p_world_m.y + sigma * noise_y + off * rt::sin(bearing);
  late.fix.p_world_m[2] = truth.p_world_m.z + sigma * noise_z;
  late.fix.yaw_rad = yaw + config_.yaw_sigma_rad * noise_yaw;
  late.fix.flags = rt::kFixPosition | rt::kFixYaw;
  static_cast<void>(late_.push_back(late));  // there is room, see above
}

bool PoseSource::take(rt::Nanoseconds now_ns, rt::UavFix& fix) {
  std::uint32_t first = late_.size();
  for (std::uint32_t i = 0; i < late_.size(); ++i) {
    if (late_[i].arrival_ns > now_ns) continue;
    if (first == late_.size() || late_[i].arrival_ns < late_[first].arrival_ns) first = i;
  }
  if (first == late_.size()) return false;
  fix = late_[first].fix;
  late_.erase(first);
  return true;
}

}  // namespace sortie::hil
