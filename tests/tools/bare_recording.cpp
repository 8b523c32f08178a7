// SPDX-License-Identifier: BSD-3-Clause
// Writes recording.bin for the programs in firmware_like/bare_metal: a simulated flight, or the IMU and track
// samples of a log.
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "drivers/channels.hpp"
#include "drivers/lcm_log.hpp"
#include "drivers/wire.hpp"
#include "estimators/uav_state/uav_estimator.hpp"
#include "firmware_like/bare_metal/recording.hpp"
#include "hil/imu_model.hpp"
#include "hil/uav/multirotor_plant.hpp"
#include "hil/uav/pose_source.hpp"
#include "planner/uav_control/uav_control.hpp"

using namespace sortie;

namespace {

class Writer {
 public:
  explicit Writer(const std::string& path) : file_(std::fopen(path.c_str(), "wb")) {
    if (file_ == nullptr) throw std::runtime_error(path + ": cannot be written");
  }
  ~Writer() { std::fclose(file_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  void put(const bare::Record& record) {
    if (std::fwrite(&record, sizeof record, 1, file_) != 1) throw std::runtime_error("the disk is full");
  }
  void put(const rt::ImuSample& s, rt::Nanoseconds now) {
    put({now,
         s.stamp_ns,
         bare::RecordKind::imu,
         s.flags,
         {s.gyr_rad_s[0], s.gyr_rad_s[1], s.gyr_rad_s[2], s.acc_m_s2[0], s.acc_m_s2[1], s.acc_m_s2[2]}});
  }
  void put(const rt::TrackSample& s, rt::Nanoseconds now) {
    put({now, s.stamp_ns, bare::RecordKind::track, s.flags, {s.left_m, s.right_m}});
  }
  void put(const rt::UavFix& f, rt::Nanoseconds now, bare::RecordKind kind) {
    put({now, f.stamp_ns, kind, f.flags, {f.p_world_m[0], f.p_world_m[1], f.p_world_m[2], f.yaw_rad}});
  }

 private:
  std::FILE* file_;
};

planner::UavModel model_of(const hil::MultirotorConfig& plant) {
  planner::UavModel model;
  model.mass_kg = 3.42;
  model.inertia_kg_m2 = {0.0608, 0.0688, 0.1489};
  planner::place_rotors(model, 6, 0.2895, 0.52359877559829887);
  model.thrust_n_s2 = plant.thrust_n_s2;
  model.moment_m = plant.moment_m;
  model.tau_up_s = plant.tau_up_s;
  model.tau_down_s = plant.tau_down_s;
  model.max_speed_rad_s = plant.max_speed_rad_s;
  return model;
}

// Three seconds on the spot, then goals around a square, in a gust.
void record_flight(Writer& out, int seconds) {
  const hil::MultirotorConfig config = hil::neo11_plant();
  hil::MultirotorPlant plant(config, {0, 0, 2}, 0.0);
  if (plant.add_gust({{3, 3, 0}, 9.0, 2.0}) != Status::ok) throw std::runtime_error("no room for a gust");
  hil::ImuModel imu(hil::ImuConfig{}, 7);
  hil::PoseSource fixes(hil::PoseSourceConfig{}, 7);
  estimators::UavEstimator estimator(estimators::UavEstimatorConfig{});
  planner::UavControlConfig settings;
  settings.model = model_of(config);
  settings.period_s = 0.002;
  auto control = std::make_unique<planner::UavControl>(settings);
  constexpr double kSquare[4][2] = {{1, 0}, {1, 1}, {0, 1}, {0, 0}};
  bool started = false;
  rt::RotorCommand command;
  for (int ms = 0; ms < 1000 * seconds; ++ms) {
    const rt::Nanoseconds now = ms * rt::kNanosecondsPerMillisecond;
    const bool stands = ms < 3000;
    if (!stands && plant.step(1e-3) != Status::ok) throw std::runtime_error("the plant does not step");
    const bool due = ms % 5 == 0;
    if (due) {
      const hil::InertialTruth truth = stands ? hil::InertialTruth{{}, {0, 0, 9.81}} : plant.take_inertial();
      rt::ImuSample sample;
      if (imu.read(truth, now, sample)) {
        out.put(sample, now);
        static_cast<void>(estimator.imu(sample, started ? control->mean_thrust_m_s2() : 9.81));
      }
    }
    fixes.observe(now, plant.state());
    rt::UavFix fix;
    while (fixes.take(now, fix)) {
      out.put(fix, now, bare::RecordKind::fix);
      static_cast<void>(estimator.fix(fix));
    }
    if (ms % 2 != 0 || stands) continue;
    if (!started) started = control->start(estimator.state()) == Status::ok;
    if (ms % 4000 == 0) {
      const auto& corner = kSquare[static_cast<std::size_t>(ms / 4000 - 1) % 4];
      rt::UavFix goal;
      goal.stamp_ns = now;
      goal.p_world_m[0] = corner[0];
      goal.p_world_m[1] = corner[1];
      goal.p_world_m[2] = 2.0;
      goal.yaw_rad = 0.3;
      out.put(goal, now, bare::RecordKind::goal);
      static_cast<void>(control->set_goal({corner[0], corner[1], 2.0}, 0.3));
    }
    static_cast<void>(control->update(estimator.state(), command));
    plant.command(command.speed_rad_s);
  }
}

void record_log(Writer& out, const std::string& path) {
  drivers::LcmLogReader reader(path);
  drivers::LogEvent event;
  // The board's clock begins with the first sample; each arrives at its stamp.
  bool begun = false;
  rt::Nanoseconds start = 0;
  const auto put_from_start = [&](auto sample) {
    if (!begun) start = sample.stamp_ns;
    begun = true;
    sample.stamp_ns -= start;
    out.put(sample, sample.stamp_ns);
  };
  while (reader.next(event) == Status::ok) {
    std::int64_t sequence = 0;
    rt::ImuSample imu;
    rt::TrackSample track;
    if (event.channel == drivers::kChannelImu && drivers::decode(event.data, imu, sequence) == Status::ok)
      put_from_start(imu);
    if (event.channel == drivers::kChannelTrack && drivers::decode(event.data, track, sequence) == Status::ok)
      put_from_start(track);
  }
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const std::string kind = count > 3 ? arguments[1] : "";
    if (kind != "flight" && kind != "log") {
      std::fputs("usage: bare_recording flight SECONDS OUT | bare_recording log LOG OUT\n", stderr);
      return 2;
    }
    Writer out(arguments[3]);
    if (kind == "flight") record_flight(out, std::stoi(arguments[2]));
    if (kind == "log") record_log(out, arguments[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bare_recording: %s\n", error.what());
    return 1;
  }
}
