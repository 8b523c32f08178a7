// SPDX-License-Identifier: BSD-3-Clause
// The simulated multirotor as something that `run` can be driven against.
#include "drivers/can_stub.hpp"
#include "firmware_like/parts/sensor_mount.hpp"
#include "firmware_like/parts/world_boxes.hpp"
#include "firmware_like/scene/units.hpp"
#include "hil/uav/uav_vehicle.hpp"
#include "toolchain/simulate/hil_config.hpp"

namespace sortie::toolchain {

namespace {

// Reads numbers of a profile.
struct Numbers {
  firmware::Profile& profile;

  double operator()(const char* path, double fallback, double low, double high, const char* unit,
                    const char* meaning) const {
    return profile.number(path, {fallback, low, high, unit, meaning});
  }
  std::uint32_t whole(const char* path, double fallback, double low, double high, const char* unit,
                      const char* meaning) const {
    return static_cast<std::uint32_t>(profile.integer(path, {fallback, low, high, unit, meaning}));
  }
};

void read_fixes(const Numbers& number, hil::UavVehicleConfig& config) {
  hil::PoseSourceConfig& fixes = config.fixes;
  fixes.period_ns =
      firmware::milliseconds(number("hil.fix_period_ms", 50, 1, 10'000, "ms", "between fixes of the place"));
  fixes.position_sigma_m =
      number("hil.fix_sigma_m", fixes.position_sigma_m, 0, 10, "m", "error of a fix, each axis");
  fixes.yaw_sigma_rad =
      number("hil.fix_yaw_sigma_rad", fixes.yaw_sigma_rad, 0, 0.5, "rad", "error of its heading");
  fixes.delay_ns =
      firmware::milliseconds(number("hil.fix_delay_ms", 50, 0, 500, "ms", "mean delay of a fix"));
  fixes.delay_spread_ns = firmware::milliseconds(
      number("hil.fix_delay_spread_ms", 10, 0, 500, "ms", "the delay is uniform, so far to both sides"));
  fixes.loss = number("hil.fix_loss", fixes.loss, 0, 1, "", "share of fixes that are lost");
  fixes.outlier = number("hil.fix_outliers", 0, 0, 1, "", "share of fixes that are far off");
  config.dark_from_ns =
      firmware::milliseconds(1e3 * number("hil.dark_from_s", 0, 0, 1e6, "s", "no fixes from here ..."));
  config.dark_to_ns = firmware::milliseconds(1e3 * number("hil.dark_to_s", 0, 0, 1e6, "s", "... to here"));
}

void read_weather(firmware::Profile& profile, hil::UavVehicleConfig& config) {
  using Kind = firmware::ColumnSpec::Kind;
  const std::vector<firmware::ColumnSpec> columns = {
      {"at_s", Kind::number, {0, 0, 1e6, "s"}, true}, {"length_s", Kind::number, {1, 0.001, 1e6, "s"}, true},
      {"x_n", Kind::number, {0, -200, 200, "N"}},     {"y_n", Kind::number, {0, -200, 200, "N"}},
      {"z_n", Kind::number, {0, -200, 200, "N"}},
  };
  for (const firmware::ProfileRow& row : profile.rows("hil.gusts", columns, hil::MultirotorPlant::kMaxGusts,
                                                      "forces on the body, in the world")) {
    config.gusts.push_back({{row.numbers.at("x_n"), row.numbers.at("y_n"), row.numbers.at("z_n")},
                            row.numbers.at("at_s"),
                            row.numbers.at("length_s")});
  }
  const char* wind = "velocity of the air";
  config.wind_m_s = {profile.number("hil.wind_x_m_s", {0, -30, 30, "m/s", wind}),
                     profile.number("hil.wind_y_m_s", {0, -30, 30, "m/s", wind}),
                     profile.number("hil.wind_z_m_s", {0, -30, 30, "m/s", wind})};
}

void read_uav_lidar(const Numbers& number, hil::UavVehicleConfig& config) {
  hil::LidarConfig& lidar = config.lidar;
  lidar.rate_hz = number.whole("hil.lidar_hz", 0, 0, 100, "Hz", "turns a second; 0: no lidar");
  lidar.rows = number.whole("hil.lidar_rows", 16, 1, hil::LidarModel::kMaxRows, "", "rows of the lidar");
  lidar.columns =
      number.whole("hil.lidar_columns", 360, 1, hil::LidarModel::kMaxColumns, "", "firings a turn");
  lidar.noise.sigma_m = number("hil.lidar_sigma_m", lidar.noise.sigma_m, 0, 1, "m", "noise of a range");
  const char* rows = "elevation of the lowest and the highest row";
  lidar.lowest_rad = firmware::kDegree * number("hil.lidar_lowest_deg", -45, -89, 89, "deg", rows);
  lidar.highest_rad = firmware::kDegree * number("hil.lidar_highest_deg", 45, -89, 89, "deg", rows);
  lidar.max_range_m =
      number("hil.lidar.max_range_m", lidar.max_range_m, 1, 1000, "m", "farther returns are not reported");
  config.lidar_faults.drop = number("hil.lidar.drop", 0, 0, 1, "", "share of scans that are not delivered");
}

// In place of the lidar.
void read_uav_camera(const Numbers& number, hil::UavVehicleConfig& config) {
  hil::DepthCameraConfig& camera = config.camera;
  camera.rate_hz = number.whole("hil.camera_hz", 0, 0, hil::DepthCamera::kMaxRate_hz, "Hz",
                                "frames of depth a second; 0: none");
  camera.columns = number.whole("hil.camera_columns", camera.columns, 2, hil::DepthCamera::kMaxColumns, "",
                                "pixels of a row");
  camera.rows =
      number.whole("hil.camera_rows", camera.rows, 2, hil::DepthCamera::kMaxRows, "", "rows of pixels");
  const char* view = "angle between the outer edges of the picture";
  camera.width_rad = firmware::kDegree * number("hil.camera_width_deg", 70, 5, 150, "deg", view);
  camera.height_rad = firmware::kDegree * number("hil.camera_height_deg", 50, 5, 150, "deg", view);
  camera.max_range_m =
      number("hil.camera_max_range_m", camera.max_range_m, 1, 1000, "m", "farther points are not reported");
  camera.noise.sigma_share = number("hil.camera_sigma_share", camera.noise.sigma_share, 0, 0.1, "",
                                    "noise of a range, as a share of it");
  camera.texture = number("hil.camera_texture", camera.texture, 0, 1, "",
                          "share of faces with texture; others have no depth");
  camera.clumps = number("hil.camera_clumps", camera.clumps, 0, 1, "",
                         "share of points in clumps far before what is there");
  config.camera_faults.drop =
      number("hil.camera_drop", 0, 0, 1, "", "share of frames that are not delivered");
}

// The sensor sits where the vehicle believes it to be.
void read_uav_mount(firmware::Profile& profile, hil::UavVehicleConfig& config) {
  if (config.lidar.rate_hz == 0 && config.camera.rate_hz == 0) return;
  const firmware::SensorMount mount = firmware::read_lidar_mount(profile);
  for (int i = 0; i < 3; ++i) {
    config.lidar.mount_m[i] = config.camera.mount_m[i] = mount.place_m[i];
    config.lidar.mount_ypr_rad[i] = config.camera.mount_ypr_rad[i] = mount.yaw_pitch_roll_rad[i];
  }
}

hil::UavVehicleConfig read_simulated_uav(firmware::Profile& profile) {
  hil::UavVehicleConfig config;
  config.seed = static_cast<std::uint64_t>(
      profile.integer("hil.seed", {1, 0, 1e15, "", "of all sensor noise and faults"}));
  const std::string airframe =
      profile.text("hil.airframe", "neo11", "the vehicle that is simulated, as RotorS describes it",
                   {"neo11", "neo9", "firefly"});
  config.airframe = airframe == "neo11"  ? hil::neo11_plant()
                    : airframe == "neo9" ? hil::neo9_plant()
                                         : hil::firefly_plant();
  const Numbers number{profile};
  const double share =
      number("hil.mass_share", 1, 0.3, 3, "", "true mass / that of the airframe; the vehicle is not told");
  config.airframe.frame_mass_kg *= share;
  config.propeller_radius_m =
      number("hil.propeller_radius_m", airframe == "firefly" ? 0.1 : 0.14, 0.01, 1, "m", "for what it hits");
  const char* start = "where it stands at the start";
  config.start_m = {number("hil.start_x_m", 0, -1000, 1000, "m", start),
                    number("hil.start_y_m", 0, -1000, 1000, "m", start), 0};
  config.start_yaw_rad =
      firmware::kDegree * number("hil.start_yaw_deg", 0, -360, 360, "deg", "heading at the start");
  const char* frame = "where the frame of its fixes lies in the world";
  config.frame_m = {number("hil.frame_x_m", 0, -1000, 1000, "m", frame),
                    number("hil.frame_y_m", 0, -1000, 1000, "m", frame),
                    number("hil.frame_z_m", 0, -1000, 1000, "m", frame)};
  config.frame_yaw_rad = firmware::kDegree * number("hil.frame_yaw_deg", 0, -360, 360, "deg", frame);
  config.lose_at_s = number("hil.lose_rotor_at_s", -1, -1, 1e6, "s", "a propeller comes off; -1: none does");
  config.lost_rotor = number.whole("hil.lost_rotor", 0, 0, 7, "", "which, counted from 0");
  config.command_faults.drop =
      number("hil.command_loss", 0, 0, 1, "", "share of frames to the rotors that are not heard");
  read_imu_alone(profile, config.imu, config.imu_faults);
  read_fixes(number, config);
  read_weather(profile, config);
  read_uav_lidar(number, config);
  read_uav_camera(number, config);
  read_uav_mount(profile, config);
  for (const firmware::WorldBox& box : firmware::read_world_boxes(profile)) {
    hil::BoxShape shape;
    shape.center_x_m = 0.5 * (box.lowest_m[0] + box.highest_m[0]);
    shape.center_y_m = 0.5 * (box.lowest_m[1] + box.highest_m[1]);
    shape.length_m = box.highest_m[0] - box.lowest_m[0];
    shape.width_m = box.highest_m[1] - box.lowest_m[1];
    shape.bottom_m = box.lowest_m[2];
    shape.top_m = box.highest_m[2];
    config.solids.push_back({hil::make_box(shape), box.from_ns});
  }
  return config;
}

// Plant and runtime are two nodes of one bus; the bus belongs to the plant's thread.
class SimulatedUav final : public firmware::SimulatedRobot {
 public:
  SimulatedUav(const hil::UavVehicleConfig& config, drivers::ScanSink* scans)
      : vehicle_(bus_.attach("runtime")),
        plant_port_(bus_.attach("plant")),
        plant_(config, plant_port_, scans),
        what_(std::string("simulated ") + config.airframe.name + ", seed " + std::to_string(config.seed) +
              ", among " + std::to_string(config.solids.size()) + " boxes"),
        has_solids_(!config.solids.empty()) {}

  void step(rt::Nanoseconds now_ns) override {
    bus_.advance(now_ns);
    static_cast<void>(plant_.step(now_ns));  // less than a step since the last: nothing to do
    bus_.advance(now_ns);
  }
  rt::TruthSample truth() const override { return plant_.truth(); }
  void set_device_clock(rt::Nanoseconds reading_ns) override { plant_.set_device_clock(reading_ns); }
  drivers::CanBus* vehicle_can() override { return &vehicle_; }
  std::string describe() const override { return what_; }
  void add_counters(std::map<std::string, std::uint64_t>& counters) const override {
    const hil::UavVehicleCounters& seen = plant_.counters();
    counters["bench_frames_sent"] = seen.frames_sent;
    counters["bench_frames_refused"] = seen.frames_refused;
    counters["bench_commands"] = seen.commands_taken;
    counters["bench_commands_repeated"] = seen.commands_repeated;
    counters["bench_rotors_stale_ms"] = seen.command_stale_steps;
    counters["bench_late_steps"] = seen.late_steps;
    counters["bench_can_frames"] = bus_.stats().frames;
    counters["bench_fixes_lost"] = plant_.fixes_lost();
    if (plant_.lidar().rays != 0) {
      counters["bench_lidar_scans"] = plant_.lidar().scans;
      counters["bench_lidar_refused"] = plant_.lidar().refused;
      counters["bench_lidar_points"] = plant_.lidar().points;
    }
    if (plant_.camera().rays != 0) {
      counters["bench_camera_frames"] = plant_.camera().scans;
      counters["bench_camera_refused"] = plant_.camera().refused;
      counters["bench_camera_points"] = plant_.camera().points;
    }
    counters["bench_collisions"] = seen.collisions;
    counters["bench_collision_ms"] = seen.collision_steps;
    if (has_solids_ && plant_.least_gap_m() < 1e6)
      counters["bench_least_gap_mm"] = static_cast<std::uint64_t>(1e3 * plant_.least_gap_m());
    counters["bench_most_tilt_mdeg"] =
        static_cast<std::uint64_t>(1e3 * plant_.most_tilt_rad() / firmware::kDegree);
    const hil::TouchDown& touch = plant_.plant().touch_down();
    counters["bench_landed"] = touch.happened ? 1 : 0;
    if (touch.happened) counters["bench_touch_down_mm_s"] = static_cast<std::uint64_t>(1e3 * touch.speed_m_s);
  }

 private:
  drivers::CanStub bus_;
  drivers::CanBus& vehicle_;
  drivers::CanBus& plant_port_;
  hil::UavVehicle plant_;
  std::string what_;
  bool has_solids_;
};

}  // namespace

std::unique_ptr<firmware::SimulatedRobot> make_simulated_uav(firmware::Profile& profile,
                                                             drivers::ScanSink* scans) {
  const hil::UavVehicleConfig config = read_simulated_uav(profile);
  try {
    return std::make_unique<SimulatedUav>(config, scans);
  } catch (const std::runtime_error& error) {
    profile.fail("hil", error.what());
  }
}

}  // namespace sortie::toolchain
