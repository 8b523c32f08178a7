// SPDX-License-Identifier: BSD-3-Clause
// A flying robot on a bare board: state estimator and controller at 500 Hz.
#include "estimators/uav_state/uav_estimator.hpp"
#include "firmware_like/bare_metal/run.hpp"
#include "planner/uav_control/uav_control.hpp"

using namespace sortie;

namespace {

// The vehicle that the recording was flown with: neo11, of its data sheet.
planner::UavControlConfig neo11() {
  planner::UavControlConfig config;
  config.model.mass_kg = 3.42;
  config.model.inertia_kg_m2 = {0.0608, 0.0688, 0.1489};
  planner::place_rotors(config.model, 6, 0.2895, 0.52359877559829887);
  config.model.thrust_n_s2 = 1.269e-5;
  config.model.moment_m = 0.016754;
  config.model.tau_up_s = 0.0182;
  config.model.tau_down_s = 0.0182;
  config.model.max_speed_rad_s = 1047.2;
  config.period_s = 0.002;
  return config;
}

struct Flight {
  explicit Flight(rt::Executive& executive) : control(neo11()) {
    const rt::GroupId group = executive.add_group({"control", 2});
    imu = executive.add_stream<rt::ImuSample>(group, "IMU", 16, 8);
    fixes = executive.add_stream<rt::UavFix>(group, "FIX", 8, 4);
    goals = executive.add_stream<rt::UavFix>(group, "GOAL", 4, 2);
    executive.add_task<rt::UavState>(group, "state", 500, [this](rt::JobContext&, rt::UavState& output) {
      // What is refused is counted by the estimator.
      for (const rt::ImuSample& sample : *imu)
        static_cast<void>(estimator.imu(sample, control.mean_thrust_m_s2()));
      for (const rt::UavFix& fix : *fixes) static_cast<void>(estimator.fix(fix));
      output = estimator.state();
    });
    executive.add_task<rt::RotorCommand>(
        group, "control", 500, [this](rt::JobContext&, rt::RotorCommand& output) {
          const rt::UavState& state = estimator.state();
          if (!started && state.verdict == rt::UavVerdict::good) started = control.start(state) == Status::ok;
          if (!started) return;
          for (const rt::UavFix& goal : *goals) {
            const double* p = goal.p_world_m;
            static_cast<void>(control.set_goal({p[0], p[1], p[2]}, goal.yaw_rad));
          }
          static_cast<void>(control.update(state, output));
        });
  }
  void take(const bare::Record& record) {
    // A full stream counts its refusals.
    if (record.kind == bare::RecordKind::imu) static_cast<void>(imu->push(bare::to_imu(record)));
    if (record.kind == bare::RecordKind::fix) static_cast<void>(fixes->push(bare::to_fix(record)));
    if (record.kind == bare::RecordKind::goal) static_cast<void>(goals->push(bare::to_fix(record)));
  }

  estimators::UavEstimator estimator{estimators::UavEstimatorConfig{}};
  planner::UavControl control;
  rt::Stream<rt::ImuSample>* imu{};
  rt::Stream<rt::UavFix>* fixes{};
  rt::Stream<rt::UavFix>* goals{};
  bool started{};
};

}  // namespace

int main() { bare::run<Flight>(); }
