// SPDX-License-Identifier: BSD-3-Clause
// The plant's error against its run time: integrator and step.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/bench/report/picture.hpp"
#include "tests/bench/uav/pilot_cost.hpp"
#include "tests/bench/uav/uav_parts.hpp"

namespace sortie::bench {
namespace {

constexpr double kControl_s = 0.01;
constexpr double kFast_s = 4.0;  // length of the fast flight

// A fast flight once more with recorded commands: places at the control periods.
struct Replayed {
  std::vector<hil::Vec3> places;
  double cost_us_s;
};

struct FastFlight {
  hil::MultirotorConfig plant;
  hil::Vec3 start;
  double yaw{};
  std::vector<rt::RotorCommand> commands;
};

// Flown in closed loop on the plant at 0.1 ms.
FastFlight fast_flight() {
  FlightSetup setup = flight_setup("neo11");
  const LegPath path = rectangle(4.0, 8.0);
  setup.control.max_tilt_rad = 0.8;
  FastFlight flight{setup.plant, {0, 0, 1}, 0.0, {}};
  hil::MultirotorPlant plant(setup.plant, flight.start, flight.yaw);
  planner::UavControl control(setup.control);
  for (int k = 0; k < static_cast<int>(kFast_s / kControl_s); ++k) {
    rt::UavState state;
    const hil::MultirotorState& truth = plant.state();
    state.stamp_ns = 1 + 10'000'000 * static_cast<rt::Nanoseconds>(k);
    state.verdict = rt::UavVerdict::good;
    rt::store({truth.p_world_m.x, truth.p_world_m.y, truth.p_world_m.z}, state.p_world_m);
    rt::store({truth.v_world_m_s.x, truth.v_world_m_s.y, truth.v_world_m_s.z}, state.v_world_m_s);
    rt::store({truth.w_body_rad_s.x, truth.w_body_rad_s.y, truth.w_body_rad_s.z}, state.w_body_rad_s);
    const hil::Quat& q = truth.q_world_body;
    rt::store(rt::Quaternion{q.w, q.x, q.y, q.z}, state.q_world_body);
    if (k == 0) (void)control.start(state);
    (void)control.track(path.at(kControl_s * k));
    rt::RotorCommand command;
    (void)control.update(state, command);
    plant.command(command.speed_rad_s);
    for (int i = 0; i < 100; ++i) (void)plant.step(1e-4);
    flight.commands.push_back(command);
  }
  return flight;
}

Replayed replayed(const FastFlight& flight, double step_s, hil::MultirotorMode mode) {
  Replayed out{{}, 1e30};
  const int inner = static_cast<int>(std::lround(kControl_s / step_s));
  for (int round = 0; round < 3; ++round) {
    hil::MultirotorPlant plant(flight.plant, flight.start, flight.yaw);
    plant.set_mode(mode);
    out.places.clear();
    const double before = cpu_us();
    for (const rt::RotorCommand& command : flight.commands) {
      plant.command(command.speed_rad_s);
      for (int i = 0; i < inner; ++i) (void)plant.step(kControl_s / inner);
      out.places.push_back(plant.state().p_world_m);
    }
    out.cost_us_s = std::min(out.cost_us_s, (cpu_us() - before) / kFast_s);
  }
  return out;
}

}  // namespace

void measure_uav_steps(const UavSettings&, Report& report) {
  const FastFlight flight = fast_flight();
  const Replayed truth = replayed(flight, 1e-4, hil::MultirotorMode::exact);
  Json rows = Json::array();
  Picture picture{"bench-uav-steps",
                  "plant",
                  "The plant's error over its run time, by step",
                  "run time, \u00b5s per simulated second",
                  "greatest error of the position in 4 s, mm",
                  true,
                  true,
                  false,
                  {}};
  for (const bool exact : {true, false}) {
    Curve curve;
    curve.name = exact ? "Runge-Kutta 4, exact lag" : "as RotorS integrates";
    if (!exact) curve.style = "dashed";
    for (const double step_s : {5e-4, 1e-3, 2e-3, 2.5e-3, 5e-3, 1e-2}) {
      const Replayed got =
          replayed(flight, step_s, exact ? hil::MultirotorMode::exact : hil::MultirotorMode::parity);
      double worst = 0.0;
      for (std::size_t k = 0; k < truth.places.size(); ++k)
        worst = std::max(worst, hil::norm(got.places[k] - truth.places[k]));
      rows.push_back({curve.name, 1e3 * step_s, got.cost_us_s, 1e3 * worst});
      curve.x.push_back(got.cost_us_s);
      curve.y.push_back(1e3 * worst);
      char label[24];
      std::snprintf(label, sizeof(label), "%g ms", 1e3 * step_s);
      curve.labels.push_back(label);
      if (exact && step_s == 1e-2)
        add_limit(report, "plant", "10 ms beside 0.1 ms, 4 s at up to 4 m/s, 8 m/s2", "mm", 1e3 * worst,
                  0.05);
    }
    picture.curves.push_back(curve);
  }
  report.add_table("plant", {"integrator", "step ms", "run time us per s", "greatest error mm"}, rows);
  report.note("plant",
              "The commands of one fast flight, 100 a second, played to the plant at each step: no "
              "controller makes up for what it does wrong.");
  add_picture(report, picture);
}

}  // namespace sortie::bench
