// SPDX-License-Identifier: BSD-3-Clause
// The simulated vehicles under the campaign.
#include <cmath>
#include <memory>

#include "hil/plant/tracked_plant.hpp"
#include "hil/uav/multirotor_plant.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"

namespace sortie::bench {

namespace {

double longest(const hil::Vec3& v) {
  return std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
}

}  // namespace

CampaignOutcome run_tracked_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  const auto scene = std::make_unique<hil::PlantScene>();
  trial.need(scene->add_half_space({0, 0, 1}, {0, 0, 0}) == Status::ok, "the scene takes no ground");
  static_cast<void>(scene->add_box({1.0, 0.2, 0.05}, {1, 0, 0, 0}, {0.2, 0.3, 0.05}));
  hil::PlantConfig config;
  if (!ops.empty())
    config.vehicle.friction = ops[0].value[6] > 0.5 ? 0.0 : (ops[0].value[6] < -0.5 ? 10.0 : 0.7);
  const auto plant = std::make_unique<hil::TrackedPlant>(config, *scene);
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    hil::PlantCommand command;
    command.left_m_s = v[0];
    command.right_m_s = v[1];
    for (int i = 0; i < 4; ++i) command.flipper_rad[i] = 1.5 * v[2 + (i + static_cast<int>(op.kind)) % 4];
    const double dt_s = 1e-9 * static_cast<double>(op.step_ns);
    if (op.kind % 32 == 31) {  // dropped, or deep in the ground
      const double height = std::isfinite(v[2]) ? std::fmin(std::fmax(v[2], -0.3), 1.0) : 0.1;
      plant->place({0, 0, height}, hil::from_yaw_pitch_roll(0.3, 0.1, 0.0));
    }
    const hil::Vec3 before = plant->p_world_body_m();
    const Status status = trial.answered(trial.real_time([&] { return plant->step(command, dt_s); }));
    const hil::Vec3 now = plant->p_world_body_m();
    for (const double at : {now.x, now.y, now.z}) trial.see(at, "the vehicle's place is not finite");
    const hil::Quat& q = plant->state().q_world_body;
    trial.need(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0) < 1e-9,
               "the vehicle's quaternion is not of length 1");
    if (status != Status::ok) {
      trial.need(longest(now - before) == 0.0, "a refused step moved the vehicle");
      continue;
    }
    trial.see(plant->report().kinetic_j, "the energy is not finite");
    trial.need(longest(plant->velocity_world_m_s({})) < 200.0,
               "the vehicle is faster than anything drives it");
    trial.need(now.z > -0.5, "the vehicle fell through the ground");
    const hil::Vec3 force = plant->specific_force_m_s2({});
    trial.see(force.x + force.y + force.z, "the specific force is not finite");
  }
  trial.need(plant->counters().rejected == 0, "the plant stopped for a result that was not finite");
  return trial.end();
}

CampaignOutcome run_multirotor_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  hil::MultirotorConfig config = hil::firefly_plant();
  config.battery.capacity_as = !ops.empty() && ops[0].value[6] > 0.0 ? 20.0 : 0.0;
  const auto plant = std::make_unique<hil::MultirotorPlant>(config, hil::Vec3{0, 0, 3}, 0.3);
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    if (op.kind % 32 == 1) {
      const auto wind = [&](double speed) { return std::fabs(speed) < 2.0 ? 5.0 * speed : 0.0; };
      plant->set_wind({wind(v[0]), wind(v[1]), 0});
    }
    if (op.kind % 64 == 33) plant->fail_rotor(whole_of(v[0], 6));
    double speeds[hil::kMaxSimulatedRotors];
    for (std::size_t i = 0; i < hil::kMaxSimulatedRotors; ++i)
      speeds[i] = 500.0 * (1.0 + v[i % kCampaignValues]);
    plant->set_mode(op.kind % 16 == 7 ? hil::MultirotorMode::parity : hil::MultirotorMode::exact);
    const double dt_s = 1e-9 * static_cast<double>(op.step_ns);
    const double before = plant->time_s();
    const Status status = trial.answered(trial.real_time([&] {
      plant->command(speeds);
      return plant->step(dt_s);
    }));
    trial.need(status == Status::ok || plant->time_s() == before, "a refused step took time");
    const hil::MultirotorState& now = plant->state();
    for (const hil::Vec3& part : {now.p_world_m, now.v_world_m_s, now.w_body_rad_s}) {
      trial.see(part.x, "the state in flight is not finite");
      trial.see(part.y, "the state in flight is not finite");
      trial.see(part.z, "the state in flight is not finite");
    }
    for (std::uint32_t i = 0; i < config.rotors; ++i)
      trial.need(plant->speed_rad_s(i) >= 0.0 && plant->speed_rad_s(i) <= config.max_speed_rad_s * 1.000001,
                 "a rotor's speed is beyond its range");
    trial.need(now.p_world_m.z >= -1e-9, "the vehicle fell through the ground");
    trial.need(plant->voltage_share() >= 0.0 && plant->voltage_share() <= 1.0,
               "the voltage is beyond its range");
  }
  return trial.end();
}

}  // namespace sortie::bench
