// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/fired_rays.hpp"

#include <map>

#include "drivers/wire_ssl.hpp"
#include "firmware_like/parts/ugv_ssl_config.hpp"

namespace sortie::toolchain {

namespace {

constexpr std::size_t kMostFrames = 1000;
constexpr std::int64_t kMostGapNs = rt::kNanosecondsPerSecond;

struct RaySensor {
  rt::Vector3 p_body;
  rt::Quaternion q_body;
  double silent_m{};
};

RaySensor read_sensor(firmware::Profile& profile) {
  firmware::SslSettings settings = firmware::read_ssl_settings(profile);
  const firmware::SensorMount mount = firmware::read_ssl_mount(profile);
  return {rt::to_vector(mount.place_m), mount.q_body_sensor(),
          firmware::read_occupancy_settings(profile, settings).silent_free_m};
}

void place_rays(const rt::SslReturns& returns, const RaySensor& sensor, const firmware::Trajectory& path,
                FiredRays& fired) {
  for (std::uint32_t i = 0; i < returns.rays; ++i) {
    FiredRay ray;
    ray.at_ns = returns.stamp_ns - 10'000 * rt::Nanoseconds{returns.age_10us[i]};
    ray.command = returns.number;
    ray.hit = returns.range_mm[i] != 0;
    firmware::TimedPose body;
    if (!interpolate(path, ray.at_ns, kMostGapNs, body)) {
      ++fired.unplaced;
      continue;
    }
    const rt::Quaternion q = rt::to_quaternion(body.q);
    const rt::Vector3 from = rt::to_vector(body.p) + rt::rotate(q, sensor.p_body);
    const double range_m = ray.hit ? rt::kSslRangeStep_m * returns.range_mm[i] : sensor.silent_m;
    const rt::Vector3 to =
        from + range_m * rt::rotate(q * sensor.q_body, rt::ssl_direction(returns.direction[i]));
    rt::store(from, ray.from_m);
    rt::store(to, ray.to_m);
    fired.rays.push_back(ray);
  }
}

// Commands by number, and when they left. Empty: the log does not say.
std::map<std::uint32_t, std::int64_t> read_commands(const firmware::LogFile& log) {
  std::map<std::uint32_t, std::int64_t> sent_us;
  for (const firmware::StoredEvent& event : log.channel(std::string(drivers::kChannelSslCommand))) {
    rt::SslCommand command;
    std::int64_t seq = 0;
    if (drivers::decode(event.message, command, seq) == Status::ok)
      sent_us.emplace(command.number, event.timestamp_us);
  }
  return sent_us;
}

}  // namespace

FiredRays fired_rays(const firmware::LogFile& log, firmware::Profile profile,
                     const firmware::Trajectory& path) {
  FiredRays fired;
  const std::vector<firmware::StoredEvent>& frames = log.channel(std::string(drivers::kChannelSsl));
  if (frames.empty() || path.empty()) return fired;
  const RaySensor sensor = read_sensor(profile);
  const std::size_t stride = (frames.size() + kMostFrames - 1) / kMostFrames;
  const std::map<std::uint32_t, std::int64_t> sent_us = read_commands(log);
  const auto was_asked = [&sent_us](std::uint32_t number, std::int64_t at_us) {
    const auto sent = sent_us.find(number);
    return sent_us.empty() || (sent != sent_us.end() && sent->second <= at_us);
  };
  std::uint32_t newest = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    rt::SslReturns returns;
    std::int64_t seq = 0;
    if (drivers::decode(frames[i].message, returns, seq) != Status::ok || returns.number <= newest ||
        !was_asked(returns.number, frames[i].timestamp_us))
      continue;
    newest = returns.number;
    ++fired.frames;
    if (i % stride == 0 || i + 1 == frames.size()) place_rays(returns, sensor, path, fired);
  }
  return fired;
}

}  // namespace sortie::toolchain
