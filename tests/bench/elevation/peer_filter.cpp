// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/elevation/peer_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sortie::bench {

namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::int64_t cell_number(double x_m, double cell_m) {
  return static_cast<std::int64_t>(std::floor(x_m / cell_m));
}

}  // namespace

PeerFilter::PeerFilter(const PeerFilterConfig& config) : config_(config) {
  const auto cells = static_cast<std::size_t>(config.size) * static_cast<std::size_t>(config.size);
  for (std::vector<float>* const layer :
       {&elevation_, &variance_, &horizontal_x_, &horizontal_y_, &horizontal_xy_, &time_})
    layer->assign(cells, kNone);
}

// A ring, as the peer's grid map is one.
bool PeerFilter::index(double x_m, double y_m, std::size_t& at) const {
  const std::int64_t x = cell_number(x_m, config_.cell_m);
  const std::int64_t y = cell_number(y_m, config_.cell_m);
  const std::int64_t low_x = cell_number(middle_[0], config_.cell_m) - config_.size / 2;
  const std::int64_t low_y = cell_number(middle_[1], config_.cell_m) - config_.size / 2;
  if (x < low_x || x >= low_x + config_.size || y < low_y || y >= low_y + config_.size) return false;
  const auto wrapped = [this](std::int64_t n) {
    return static_cast<std::size_t>(((n % config_.size) + config_.size) % config_.size);
  };
  at = wrapped(y) * static_cast<std::size_t>(config_.size) + wrapped(x);
  return true;
}

void PeerFilter::move(double x_m, double y_m) {
  const double before[2] = {middle_[0], middle_[1]};
  middle_[0] = x_m;
  middle_[1] = y_m;
  const std::int64_t now_x = cell_number(x_m, config_.cell_m) - config_.size / 2;
  const std::int64_t now_y = cell_number(y_m, config_.cell_m) - config_.size / 2;
  const std::int64_t was_x = cell_number(before[0], config_.cell_m) - config_.size / 2;
  const std::int64_t was_y = cell_number(before[1], config_.cell_m) - config_.size / 2;
  if (now_x == was_x && now_y == was_y) return;
  for (std::int64_t y = now_y; y < now_y + config_.size; ++y) {
    for (std::int64_t x = now_x; x < now_x + config_.size; ++x) {
      const bool stayed = x >= was_x && x < was_x + config_.size && y >= was_y && y < was_y + config_.size;
      std::size_t at = 0;
      const double half = 0.5 * config_.cell_m;
      if (stayed || !index(static_cast<double>(x) * config_.cell_m + half,
                           static_cast<double>(y) * config_.cell_m + half, at)) {
        continue;
      }
      elevation_[at] = variance_[at] = horizontal_x_[at] = horizontal_y_[at] = horizontal_xy_[at] = kNone;
    }
  }
}

void PeerFilter::clean() {
  for (float& v : variance_)
    v = v > config_.most_variance_m2 ? std::numeric_limits<float>::infinity()
                                     : std::max(v, config_.least_variance_m2);
}

void PeerFilter::predict(float variance_m2) {
  for (std::size_t i = 0; i < variance_.size(); ++i) {
    variance_[i] += variance_m2;
    horizontal_x_[i] += variance_m2;
    horizontal_y_[i] += variance_m2;
    horizontal_xy_[i] += 0.0f;
  }
  clean();
}

void PeerFilter::add(const rt::PointScan& scan, const mapping::SensorPose& pose, double now_s) {
  // The row of the rotation that makes a height, for the variance of a return.
  const rt::Vector3 up = rt::rotate_back(pose.q_world_sensor, {0, 0, 1});
  for (std::uint32_t i = 0; i < scan.header.points; ++i) {
    const rt::ScanPoint& p = scan.points[i];
    const rt::Vector3 local{static_cast<double>(p.x_m), static_cast<double>(p.y_m),
                            static_cast<double>(p.z_m)};
    const rt::Vector3 world = pose.p_world_sensor_m + rt::rotate(pose.q_world_sensor, local);
    std::size_t at = 0;
    if (!index(world.x, world.y, at)) continue;
    // Along the beam the device's constant, across it the beam's radius; both as they tilt into the height.
    const double range = rt::norm(local);
    const float radius = config_.beam_constant_m + config_.beam_angle_rad * static_cast<float>(range);
    const auto along = static_cast<float>(rt::dot(up, local) / range);
    const float variance = along * along * config_.least_radius_m * config_.least_radius_m +
                           (1 - along * along) * radius * radius;
    const auto z = static_cast<float>(world.z);
    float& height = elevation_[at];
    float& known = variance_[at];
    if (!std::isfinite(height) || !std::isfinite(known)) {
      height = z;
      known = variance;
      horizontal_x_[at] = horizontal_y_[at] = config_.least_variance_m2;
      horizontal_xy_[at] = 0;
      continue;
    }
    if (std::fabs(z - height) > config_.gate * std::sqrt(known)) {
      const bool same_scan =
          static_cast<float>(now_s) - time_[at] <= static_cast<float>(config_.scanning_duration_s);
      if (same_scan && height > z) continue;
      if (same_scan) {
        height = z;
        known = variance;
      } else {
        known += config_.multi_height_noise_m2;
      }
      continue;
    }
    height = (known * z + variance * height) / (known + variance);
    known = variance * known / (variance + known);
    time_[at] = static_cast<float>(now_s);
    horizontal_x_[at] = horizontal_y_[at] = config_.least_variance_m2;
    horizontal_xy_[at] = 0;
  }
  clean();
}

bool PeerFilter::height(double x_m, double y_m, double& height_m) const {
  std::size_t at = 0;
  if (!index(x_m, y_m, at) || !std::isfinite(elevation_[at]) || !std::isfinite(variance_[at])) return false;
  height_m = static_cast<double>(elevation_[at]);
  return true;
}

}  // namespace sortie::bench
