// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grid/sweep.hpp"

#include <cmath>

namespace sortie::mapping {
namespace {

constexpr rt::Nanoseconds kAgeStepNs = 10 * rt::kNanosecondsPerMicrosecond;

bool are_ranges(double min_m, double max_m) {
  return std::isfinite(min_m) && std::isfinite(max_m) && min_m >= 0.0 && min_m < max_m;
}

}  // namespace

struct Sweeps::Moment {
  Status status{Status::ok};
  rt::RotationMatrix turn;  // sensor then -> sensor at the stamp
  rt::Vector3 shift_m;
};

Sweeps::Sweeps(const SweepConfig& config, std::span<rt::ScanPoint> memory)
    : config_(config), memory_(memory), robot_(config.robot) {
  const rt::Quaternion& q = config.q_body_sensor;
  const bool is_rotation = rt::is_finite(q) && std::fabs(rt::squared_norm(q) - 1.0) < 1e-6;
  if (robot_.usable() != Status::ok || !is_rotation || !rt::is_finite(config.p_body_sensor_m) ||
      !are_ranges(config.min_range_m, config.max_range_m) || config.max_ahead_ns < 0 || memory.empty())
    usable_ = Status::out_of_range;
}

Status Sweeps::set_ranges(double min_m, double max_m) {
  if (!are_ranges(min_m, max_m)) return Status::out_of_range;
  config_.min_range_m = min_m;
  config_.max_range_m = max_m;
  return Status::ok;
}

Status Sweeps::set_flippers(const double (&angle_rad)[rt::kFlippers]) {
  const Status status = robot_.set_flippers(angle_rad);
  if (status != Status::ok) return status;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) flipper_rad_[i] = angle_rad[i];
  return Status::ok;
}

Status Sweeps::moment_at(rt::Nanoseconds stamp_ns, const RigidPose& reference, Moment& moment) const {
  StampedPose body;
  const Status status = poses_.at(stamp_ns, config_.max_ahead_ns, body);
  if (status != Status::ok) return status;
  const rt::Quaternion q = body.q * config_.q_body_sensor;
  const rt::Vector3 p = body.p + rt::rotate(body.q, config_.p_body_sensor_m);
  moment.turn = rt::to_matrix(rt::conjugate(reference.q) * q);
  moment.shift_m = rt::rotate_back(reference.q, p - reference.p);
  return Status::ok;
}

StraightSweep Sweeps::straighten(const rt::PointScan& sweep) {
  StraightSweep result;
  result.counts.in = sweep.header.points;
  result.scan.header = sweep.header;
  result.scan.header.points = 0;
  result.scan.points = memory_.data();
  result.status = usable_;
  const rt::Nanoseconds stamp_ns = sweep.header.stamp_ns + config_.time_offset_ns;
  StampedPose body;
  if (result.status == Status::ok) result.status = poses_.at(stamp_ns, config_.max_ahead_ns, body);
  if (result.status != Status::ok) {
    result.counts.unplaced = sweep.header.points;
  } else {
    result.pose = {body.p + rt::rotate(body.q, config_.p_body_sensor_m), body.q * config_.q_body_sensor};
    std::uint16_t age = 0;
    Moment moment;  // at the stamp itself nothing moved
    for (std::uint32_t i = 0; i < sweep.header.points; ++i) {
      const rt::ScanPoint& point = sweep.points[i];
      if (point.age_10us != age) {
        age = point.age_10us;
        moment.status = moment_at(stamp_ns - kAgeStepNs * age, result.pose, moment);
      }
      place(point, moment, result);
    }
  }
  rt::add_fields(result.counts, counts_);
  return result;
}

void Sweeps::place(const rt::ScanPoint& point, const Moment& moment, StraightSweep& result) {
  const rt::Vector3 seen{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                         static_cast<double>(point.z_m)};
  const double range2 = rt::dot(seen, seen);
  SweepCounts& counts = result.counts;
  if (!std::isfinite(range2)) {
    ++counts.not_finite;
  } else if (range2 < config_.min_range_m * config_.min_range_m) {
    ++counts.too_near;
  } else if (range2 > config_.max_range_m * config_.max_range_m) {
    ++counts.too_far;
  } else if (is_on_robot(config_.p_body_sensor_m + rt::rotate(config_.q_body_sensor, seen))) {
    ++counts.on_robot;
  } else if (moment.status != Status::ok) {
    ++counts.unplaced;
  } else if (result.scan.header.points >= memory_.size()) {
    ++counts.scan_full;
  } else {
    const rt::Vector3 p = moment.turn * seen + moment.shift_m;
    memory_[result.scan.header.points++] = {static_cast<float>(p.x), static_cast<float>(p.y),
                                            static_cast<float>(p.z), point.intensity, 0};
    ++counts.used;
  }
}

void Sweeps::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "sweeps")
      .fixed(config_, usable_, memory_)
      .by_hand(poses_, robot_)
      .state(flipper_rad_, counts_);
  poses_.archive(archive);
  if (!archive.is_reading() || archive.status() != Status::ok) return;
  if (robot_.set_flippers(flipper_rad_) != Status::ok)
    archive.fail(Status::malformed, "flipper angles that are not finite");
}

}  // namespace sortie::mapping
