// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/hil_config.hpp"

#include "firmware_like/parts/sensor_mount.hpp"
#include "firmware_like/parts/ugv_ssl_config.hpp"
#include "firmware_like/scene/units.hpp"

namespace sortie::toolchain {

namespace {

// What both kinds of sensor do wrong, below `table`.
void read_noise(firmware::Profile& profile, const std::string& table, hil::RangeNoiseConfig& noise) {
  read_number(profile, table + "sigma_share", noise.sigma_share, 0, 0.1, "", "noise of a range, share of it");
  read_number(profile, table + "bias_m", noise.bias_m, -1, 1, "m", "added to every range");
  read_number(profile, table + "resolution_m", noise.resolution_m, 0, 1, "m",
              "ranges are multiples of it; 0: any");
  read_number(profile, table + "loss", noise.loss, 0, 1, "", "share of returns that are lost");
  const double graze_deg =
      profile.number(table + "graze_deg",
                     {0, 0, 90, "deg", "rays flatter than this to a surface often do not return; 0: all do"});
  noise.graze_cos = rt::sincos(graze_deg * firmware::kDegree).sin;
  read_number(profile, table + "full_range_m", noise.full_range_m, 0, 1000, "m",
              "rays from beyond often do not return; 0: all do");
  noise.divergence_rad =
      1e-3 * profile.number(table + "divergence_mrad", {1e3 * noise.divergence_rad, 0, 50, "mrad",
                                                        "half angle of the beam: mixes ranges at edges"});
  noise.stamp_jitter_ns = static_cast<rt::Nanoseconds>(
      1e3 * profile.number(table + "stamp_jitter_us", {0, 0, 1000, "us", "sigma of a scan's stamp"}));
}

// The mirror's lines and the mount, for a lidar that is a rolling laser.
void read_rolling(firmware::Profile& profile, hil::RollingLaserConfig& laser) {
  read_number(profile, "hil.lidar.line_hz", laser.line_hz, 1, 200, "Hz", "rotating_2d: lines a second");
  read_number(profile, "hil.lidar.beams", laser.beams, 2, 4096, "", "rotating_2d: rays of a line");
  laser.fov_rad =
      firmware::kDegree *
      profile.number("hil.lidar.fov_deg",
                     {270, 1, 359, "deg", "rotating_2d: from the first ray of a line to the last"});
  read_number(profile, "hil.lidar.lines_per_scan", laser.lines_per_scan, 1, 100, "",
              "rotating_2d: handed over together, in 0.655 s at most");
  laser.roll_period_ns = static_cast<rt::Nanoseconds>(
      1e9 * profile.number("hil.lidar.roll_period_s", {1e-9 * static_cast<double>(laser.roll_period_ns), 0.1,
                                                       100, "s", "rotating_2d: of one turn of the mount"}));
  read_number(profile, "hil.lidar.encoder_ticks", laser.encoder_ticks, 1, 1 << 20, "",
              "rotating_2d: of the mount, a turn");
}

void read_lidar(firmware::Profile& profile, hil::UgvConfig& config) {
  const std::string kind = profile.text("hil.lidar.kind", "rows",
                                        "rows: evenly spaced; rows_64: staggered, with a device's own "
                                        "calibration; rotating_2d: one line that a mount rolls",
                                        {"rows", "rows_64", "rotating_2d"});
  if (kind == "rows_64") config.lidar = hil::make_rows_64(config.seed);
  if (kind == "rotating_2d") config.lidar_kind = hil::LidarKind::rotating_2d;
  hil::LidarConfig& lidar = config.lidar;
  read_number(profile, "hil.lidar_hz", lidar.rate_hz, 0, 100, "Hz", "turns a second; 0: no lidar");
  read_number(profile, "hil.lidar_rows", lidar.rows, 1, hil::LidarModel::kMaxRows, "", "rows of the lidar");
  if (lidar.row_table && lidar.rows != 64)
    profile.fail("hil.lidar_rows", "must be 64 for hil.lidar.kind = \"rows_64\"");
  read_number(profile, "hil.lidar_columns", lidar.columns, 1, hil::LidarModel::kMaxColumns, "",
              "firings a turn");
  read_number(profile, "hil.lidar_sigma_m", lidar.noise.sigma_m, 0, 1, "m", "noise of a range");
  hil::RollingLaserConfig& laser = config.rolling_laser;
  read_rolling(profile, laser);
  if (lidar.rate_hz == 0) laser.line_hz = 0;
  const bool rolls = config.lidar_kind == hil::LidarKind::rotating_2d;
  lidar.max_range_m = laser.max_range_m = profile.number(
      "hil.lidar.max_range_m",
      {rolls ? laser.max_range_m : lidar.max_range_m, 1, 1000, "m", "farther returns are not reported"});
  read_noise(profile, "hil.lidar.", lidar.noise);
  laser.noise = lidar.noise;
  config.lidar_faults.drop =
      profile.number("hil.lidar.drop", {0, 0, 1, "", "share of scans that are not delivered"});
  const firmware::SensorMount mount = firmware::read_lidar_mount(profile);
  for (int i = 0; i < 3; ++i) {
    lidar.mount_m[i] = laser.mount_m[i] = mount.place_m[i];
    lidar.mount_ypr_rad[i] = laser.mount_ypr_rad[i] = mount.yaw_pitch_roll_rad[i];
  }
}

void read_ssl(firmware::Profile& profile, hil::UgvConfig& config) {
  hil::SslConfig& ssl = config.ssl;
  ssl.enabled = profile.flag("hil.ssl.enabled", false, "there is a solid-state lidar; tasks.ssl talks to it");
  ssl.frame_ns = static_cast<rt::Nanoseconds>(
      1e6 * profile.number("hil.ssl.frame_ms", {1e-6 * static_cast<double>(ssl.frame_ns), 1, 500, "ms",
                                                "time that the rays of one command take"}));
  read_number(profile, "hil.ssl.max_range_m", ssl.max_range_m, 1, 65, "m",
              "farther returns are not reported");
  read_number(profile, "hil.ssl.sigma_m", ssl.noise.sigma_m, 0, 1, "m", "noise of a range");
  read_noise(profile, "hil.ssl.", ssl.noise);
  config.ssl_faults.drop =
      profile.number("hil.ssl.drop", {0, 0, 1, "", "share of frames that are not delivered"});
  const firmware::SensorMount mount = firmware::read_ssl_mount(profile);
  for (int i = 0; i < 3; ++i) {
    ssl.mount_m[i] = mount.place_m[i];
    ssl.mount_ypr_rad[i] = mount.yaw_pitch_roll_rad[i];
  }
}

void add(const char* sensor, const hil::RangeCounters& rays, std::map<std::string, std::uint64_t>& counters) {
  const std::string name = std::string("bench_") + sensor;
  counters[name + "_rays"] = rays.rays;
  counters[name + "_returned"] = rays.returned;
  counters[name + "_weak"] = rays.weak;
  counters[name + "_mixed"] = rays.mixed;
  counters[name + "_own"] = rays.own;
  counters[name + "_refused"] = rays.refused;
}

}  // namespace

void read_range_sensors(firmware::Profile& profile, hil::UgvConfig& config) {
  read_lidar(profile, config);
  read_ssl(profile, config);
  config.self_hits =
      profile.flag("hil.self_hits", false, "the range sensors see the robot itself, flippers and all");
}

void add_range_counters(const hil::UgvPlant& plant, std::map<std::string, std::uint64_t>& counters) {
  if (plant.lidar_ranges().rays > 0) add("lidar", plant.lidar_ranges(), counters);
  if (plant.ssl().ranges().rays > 0) add("ssl", plant.ssl().ranges(), counters);
}

}  // namespace sortie::toolchain
