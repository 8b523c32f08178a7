// SPDX-License-Identifier: BSD-3-Clause
// One simulated flight.
#include "tests/bench/uav/flight.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>

#include "tests/bench/uav/flight_senses.hpp"
#include "tests/bench/uav/lee.hpp"

namespace sortie::bench {

planner::UavModel model_of(const hil::MultirotorConfig& plant) {
  planner::UavModel model;
  const hil::Vec3 inertia = hil::total_inertia_kg_m2(plant);
  model.mass_kg = hil::total_mass_kg(plant);
  model.inertia_kg_m2 = {inertia.x, inertia.y, inertia.z};
  model.rotors = plant.rotors;
  for (std::uint32_t i = 0; i < plant.rotors; ++i) {
    const hil::SimulatedRotor& rotor = plant.rotor[i];
    model.rotor[i] = {{rotor.place_m.x, rotor.place_m.y, rotor.place_m.z}, rotor.direction};
  }
  model.thrust_n_s2 = plant.thrust_n_s2;
  model.moment_m = plant.moment_m;
  model.tau_up_s = plant.tau_up_s;
  model.tau_down_s = plant.tau_down_s;
  model.max_speed_rad_s = plant.max_speed_rad_s;
  return model;
}

planner::UavModel believed_model(const std::string& vehicle) {
  constexpr double kThirtyDegrees = 0.52359877559829887;
  if (vehicle == "firefly") {
    planner::UavModel model = model_of(hil::firefly_plant());
    model.mass_kg = 1.56779;
    model.inertia_kg_m2 = {0.0347563, 0.0458929, 0.0977};
    planner::place_rotors(model, 6, 0.215, kThirtyDegrees);
    return model;
  }
  planner::UavModel model = model_of(vehicle == "neo9" ? hil::neo9_plant() : hil::neo11_plant());
  model.mass_kg = vehicle == "neo9" ? 2.70703 : 3.42;
  model.inertia_kg_m2 =
      vehicle == "neo9" ? rt::Vector3{0.0341171, 0.0363089, 0.0627386} : rt::Vector3{0.0608, 0.0688, 0.1489};
  planner::place_rotors(model, 6, vehicle == "neo9" ? 0.2495 : 0.2895, kThirtyDegrees);
  return model;
}

FlightSetup flight_setup(const std::string& vehicle) {
  FlightSetup setup;
  setup.plant = vehicle == "firefly" ? hil::firefly_plant()
                                     : (vehicle == "neo9" ? hil::neo9_plant() : hil::neo11_plant());
  setup.control.model = believed_model(vehicle);
  return setup;
}

hil::Gust diagonal_gust(double force_n, double start_s, double length_s) {
  const double each = force_n * 0.70710678118654752;
  return {{each, each, 0.0}, start_s, length_s};
}

namespace {

rt::Vector3 to_rt(const hil::Vec3& v) { return {v.x, v.y, v.z}; }

// Commands that reach the rotors later.
class CommandLine {
 public:
  explicit CommandLine(double delay_s) : delay_s_(delay_s) {}
  void put(double now_s, const rt::RotorCommand& command) { late_.push_back({now_s + delay_s_, command}); }
  void deliver(double now_s, hil::MultirotorPlant& plant) {
    while (!late_.empty() && late_.front().at_s <= now_s + 1e-9) {
      plant.command(late_.front().command.speed_rad_s);
      late_.pop_front();
    }
  }

 private:
  struct Late {
    double at_s;
    rt::RotorCommand command;
  };
  double delay_s_;
  std::deque<Late> late_;
};

void judge(const FlightSetup& setup, const FlightSample& sample, double& square, long& count,
           FlightResult& result) {
  result.max_tilt_rad = std::max(result.max_tilt_rad, sample.tilt_rad);
  result.last_error_m = sample.error_m;
  if (!std::isfinite(sample.error_m)) result.finite = false;
  if (sample.time_s < setup.judge_from_s) return;
  square += sample.error_m * sample.error_m;
  ++count;
  result.peak_m = std::max(result.peak_m, sample.error_m);
}

}  // namespace

FlightResult fly(const FlightSetup& setup) {
  const planner::FlatReference start = setup.path ? setup.path(0.0) : setup.judged(0.0);
  hil::MultirotorPlant plant(setup.plant, {start.p_m.x, start.p_m.y, start.p_m.z}, start.yaw_rad);
  for (const hil::Gust& gust : setup.gusts) (void)plant.add_gust(gust);
  plant.set_wind(setup.wind_m_s);
  plant.set_mode(setup.mode);
  const bool ours = setup.pilot == Pilot::ours || setup.pilot == Pilot::ours_unobserved;
  auto control = std::make_unique<planner::UavControl>(setup.control);
  const LeeGains gains = lee_gains(setup.plant.name);
  LeeController lee(
      setup.control.model,
      setup.pilot == Pilot::lee_integral ? with_integrator(gains, setup.integral_share_hz) : gains,
      setup.control.period_s);
  auto senses = std::make_unique<FlightSenses>(setup);
  CommandLine line(setup.command_delay_s);
  FlightResult result;
  const double period_s = setup.control.period_s;
  const long inner = std::max(1L, std::lround(period_s / setup.plant_step_s));
  const long periods = std::lround(setup.seconds / period_s);
  double square = 0.0;
  long count = 0;
  bool started = false;
  for (long k = 0; k < periods; ++k) {
    const double now_s = static_cast<double>(k) * period_s;
    if (setup.lose_rotor_at_s >= 0.0 && now_s >= setup.lose_rotor_at_s - 1e-9)
      plant.fail_rotor(setup.lose_rotor);
    if (setup.thrust_share != 1.0 && k == 1) plant.set_thrust_share(setup.thrust_share);
    const double expected = started && ours ? control->mean_thrust_m_s2() : setup.control.model.gravity_m_s2;
    const rt::UavState state = senses->state(plant, now_s, expected);
    if (!started) {
      if (control->start(state) != Status::ok) result.finite = false;
      started = true;
    }
    rt::RotorCommand command;
    planner::FlatReference wanted = setup.path ? setup.path(now_s) : setup.judged(now_s);
    if (ours) {
      if (setup.path) (void)control->track(wanted);
      if (setup.command) setup.command(now_s, *control);
      (void)control->update(state, command);
      if (!setup.path && !setup.judged) wanted = control->reference();
    } else {
      lee.update(state, wanted, command);
    }
    senses->expect(ours ? control->mean_thrust_m_s2() : setup.control.model.gravity_m_s2);
    for (std::uint32_t i = 0; i < command.rotors; ++i) {
      const double speed = command.speed_rad_s[i];
      if (!(speed >= 0.0 && speed <= setup.plant.max_speed_rad_s * (ours ? 1.0 : 1e9))) result.finite = false;
    }
    FlightSample sample{now_s, plant.state().p_world_m, wanted.p_m, plant.tilt_rad(), state, 0.0};
    sample.error_m = rt::norm(to_rt(sample.p_m) - sample.wanted_m);
    judge(setup, sample, square, count, result);
    result.record.push_back(sample);
    line.put(now_s, command);
    for (long i = 0; i < inner; ++i) {
      line.deliver(now_s + static_cast<double>(i) * setup.plant_step_s, plant);
      if (plant.step(period_s / static_cast<double>(inner)) != Status::ok) result.finite = false;
      senses->observe(plant);
    }
  }
  result.rms_m = std::sqrt(square / static_cast<double>(std::max(1L, count)));
  result.touch_down = plant.touch_down();
  result.counters = control->counters();
  result.phase = control->phase();
  result.estimate_rms_m = senses->estimate_rms_m();
  if (setup.time_estimate) result.estimate_cost_us_s = senses->estimate_cost_us_s();
  return result;
}

}  // namespace sortie::bench
