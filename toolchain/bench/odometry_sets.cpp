// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/odometry_sets.hpp"

#include <algorithm>
#include <stdexcept>

#include "drivers/wire.hpp"
#include "drivers/wire_records.hpp"
#include "firmware_like/live/live_run.hpp"
#include "firmware_like/parts/odometry_part.hpp"
#include "rt/fields.hpp"
#include "toolchain/bench/temporary_log.hpp"

namespace sortie::toolchain {
namespace {

using Kind = OdometryEvent::Kind;

constexpr double kFinest_hz = 1000;

template <class Sample>
void read_channel(const firmware::LogFile& log, std::string_view channel, Kind kind,
                  std::vector<Sample>& samples, std::vector<OdometryEvent>& events) {
  for (const firmware::StoredEvent& stored : log.channel(std::string(channel))) {
    Sample sample;
    std::int64_t seq = 0;
    if (drivers::decode(stored.message, sample, seq) != Status::ok) continue;
    events.push_back({stored.timestamp_us, kind, static_cast<std::uint32_t>(samples.size())});
    samples.push_back(sample);
  }
}

void read_flippers(const firmware::LogFile& log, OdometrySet& set) {
  for (const firmware::StoredEvent& stored : log.channel("FLIPPER")) {
    drivers::CustomView view;
    if (drivers::decode(stored.message, view) != Status::ok) continue;
    if (view.data.size() != rt::canonical_size<rt::FlipperSample>()) continue;
    set.events.push_back(
        {stored.timestamp_us, Kind::flippers, static_cast<std::uint32_t>(set.flippers.size())});
    rt::decode_canonical(view.data.data(), set.flippers.emplace_back());
  }
}

void read_settings(firmware::Profile profile, OdometrySet& set) {
  std::vector<std::byte> memory(1 << 16);
  rt::Arena arena(memory);
  rt::Executive executive(arena, rt::kNanosecondsPerMillisecond, 0);
  firmware::VehicleBuilder builder(profile, executive, {});
  set.attitude = firmware::read_attitude_config(builder);
  set.track_aid = profile.text("attitude.track_aid", "on", "", {"on", "off"}) == "on";
  set.has_odometry = builder.wants("odometry");
  if (set.has_odometry) set.odometry = firmware::read_odometry_config(builder);
}

}  // namespace

OdometrySet read_odometry_set(const firmware::LogFile& log, const std::string& scene) {
  OdometrySet set;
  read_flippers(log, set);
  read_channel(log, drivers::kChannelImu, Kind::imu, set.imu, set.events);
  read_channel(log, drivers::kChannelTrack, Kind::track, set.track, set.events);
  // A job takes flippers, then all attitudes, then the tracks.
  std::stable_sort(set.events.begin(), set.events.end(), [](const OdometryEvent& a, const OdometryEvent& b) {
    return a.received_us != b.received_us ? a.received_us < b.received_us : a.kind < b.kind;
  });
  if (set.imu.size() < 2) throw std::runtime_error(log.path() + ": holds no inertial samples");
  set.duration_s = rt::to_seconds(set.imu.back().stamp_ns - set.imu.front().stamp_ns);
  set.rate_hz = static_cast<double>(set.imu.size() - 1) / set.duration_s;
  set.truth = log.truth();
  read_settings(
      scene.empty() ? firmware::Profile(log.header().scene_toml, log.path()) : firmware::load_scene(scene),
      set);
  set.error = set.has_odometry && !set.track.empty() ? "ate_rmse_m" : "inclination_rmse_deg";
  return set;
}

OdometrySet drive_odometry_set(const firmware::VehicleRegistry& vehicles,
                               const firmware::SimulatorFactory& simulator, const std::string& scene,
                               double seconds) {
  const TemporaryFolder scratch("sortie-odometry");
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = {"hil.imu_hz=1000", "hil.lidar_rows=4", "hil.lidar_columns=64"};
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = scratch.file("drive.lcm");
  options.lcm_url = "none";
  static_cast<void>(firmware::run_live(vehicles, simulator, options));
  const firmware::LogFile log(options.record);
  OdometrySet set = read_odometry_set(log, "");
  set.name = scene;
  set.rate_hz = kFinest_hz;
  set.profile_rate_hz = 200;
  set.error = "vertical_rmse_m";
  return set;
}

OdometrySet thinned(const OdometrySet& set, std::uint32_t every) {
  if (every <= 1) return set;
  OdometrySet out = set;
  out.rate_hz = set.rate_hz / every;
  out.imu.clear();
  out.events.clear();
  rt::ImuSample sum;
  bool whole_rates = true;
  std::uint32_t n = 0;
  std::uint32_t rates = 0;  // of those, with a rate and with a force: what is not there counts for nothing
  std::uint32_t forces = 0;
  for (const OdometryEvent& event : set.events) {
    if (event.kind != Kind::imu) {
      out.events.push_back(event);
      continue;
    }
    const rt::ImuSample& sample = set.imu[event.index];
    const bool has_rate = (sample.flags & rt::kImuGyr) != 0;
    const bool has_force = (sample.flags & rt::kImuAcc) != 0;
    rates += has_rate ? 1 : 0;
    forces += has_force ? 1 : 0;
    for (int i = 0; i < 3; ++i) {
      sum.gyr_rad_s[i] += has_rate ? sample.gyr_rad_s[i] : 0.0;
      sum.acc_m_s2[i] += has_force ? sample.acc_m_s2[i] : 0.0;
    }
    sum.flags |= sample.flags;
    whole_rates = whole_rates &&
                  ((sample.flags & rt::kImuSaturated) == 0 || (sample.flags & rt::kImuOnlyAccSaturated) != 0);
    if (++n < every) continue;
    if (!whole_rates) sum.flags &= ~std::uint32_t{rt::kImuOnlyAccSaturated};
    sum.stamp_ns = sample.stamp_ns;
    for (int i = 0; i < 3; ++i) {
      sum.gyr_rad_s[i] /= std::max(rates, 1u);
      sum.acc_m_s2[i] /= std::max(forces, 1u);
    }
    out.events.push_back({event.received_us, Kind::imu, static_cast<std::uint32_t>(out.imu.size())});
    out.imu.push_back(sum);
    sum = {};
    whole_rates = true;
    n = rates = forces = 0;
  }
  return out;
}

}  // namespace sortie::toolchain
