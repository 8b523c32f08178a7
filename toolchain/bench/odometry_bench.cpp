// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/odometry_bench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "estimators/attitude.hpp"
#include "rt/posix/clock.hpp"
#include "toolchain/judge/pareto.hpp"

namespace sortie::toolchain {
namespace {

using Kind = OdometryEvent::Kind;

struct Variant {
  estimators::AttitudeConfig attitude;
  estimators::TrackOdometryConfig odometry;
  bool track_aid{};
  bool narrow{};
  bool changes{true};  ///< false: on this set it is the same as everything
};

Variant variant_of(const OdometrySet& set, const std::string& name) {
  Variant v{set.attitude, set.odometry, set.track_aid && set.has_odometry, false, true};
  if (name == "all, float") {
    v.narrow = true;
  } else if (name == "no bias filter") {
    v.attitude.bias_sigma_initial_rad_s = 0.0;
  } else if (name == "no coning") {
    v.attitude.coning = false;
  } else if (name == "no track aid") {
    v.changes = v.track_aid;
    v.track_aid = false;
  } else if (name == "no obstacle modes") {
    v.changes = v.odometry.obstacles;
    v.odometry.obstacles = false;
  } else if (name == "no turning centre") {
    v.changes = v.odometry.icr_x_m != 0.0 || v.odometry.learn_steering;
    v.odometry.icr_x_m = 0.0;
    v.odometry.learn_steering = false;
    v.odometry.track_width_m = 0.0;
  } else if (name != "all, double") {
    throw std::invalid_argument("no such variant: " + name);
  }
  return v;
}

struct Outcome {
  firmware::Trajectory path;
  double seconds{};
  std::uint64_t slips{};
};

/// The chain as the vehicle's control group runs it, over all events.
template <class Filter>
Outcome run_chain(const OdometrySet& set, const Variant& v) {
  Filter attitude(v.attitude);
  estimators::TrackOdometry odometry(v.odometry);
  const bool moves = set.has_odometry && !set.track.empty();
  Outcome outcome;
  outcome.path.reserve(moves ? set.track.size() : set.imu.size());
  const rt::Nanoseconds begin = rt::posix::thread_cpu_now();  // what another one took away is not in it
  for (const OdometryEvent& event : set.events) {
    if (event.kind == Kind::imu) {
      const rt::ImuSample& sample = set.imu[event.index];
      if (attitude.update(sample) != Status::ok) continue;
      const rt::AttitudeEstimate& estimate = attitude.estimate();
      if (moves) {
        static_cast<void>(odometry.observe(estimate));
        odometry.feel(sample);
        continue;
      }
      firmware::TimedPose& pose = outcome.path.emplace_back();
      pose.stamp_ns = estimate.stamp_ns;
      std::copy_n(estimate.q_world_body, 4, pose.q);
      pose.flags = rt::kTruthOrientation;
    } else if (event.kind == Kind::flippers) {
      const double* angle = set.flippers[event.index].angle_rad;
      odometry.set_flippers({0.5 * (angle[0] + angle[1]), 0.5 * (angle[2] + angle[3])});
    } else if (moves) {
      if (odometry.update(set.track[event.index]) != Status::ok) continue;
      const rt::PoseEstimate& pose = odometry.estimate();
      attitude.set_moving(odometry.belts_run());
      if (v.track_aid && odometry.velocity_known())
        static_cast<void>(attitude.set_track_velocity(rt::to_vector(pose.v_body_m_s), pose.stamp_ns));
      outcome.path.push_back(firmware::to_timed_pose(pose));
    }
  }
  outcome.seconds = rt::to_seconds(rt::posix::thread_cpu_now() - begin);
  outcome.slips = odometry.counters().slips;
  return outcome;
}

Outcome run_variant(const OdometrySet& set, const Variant& v) {
  return v.narrow ? run_chain<estimators::AttitudeFloat>(set, v) : run_chain<estimators::Attitude>(set, v);
}

void mark_front(const std::string& error, std::vector<OdometryCell>& cells) {
  std::vector<CostAndError> points;
  for (const OdometryCell& cell : cells) {
    const auto found = cell.errors.find(error);
    points.push_back({cell.cost_us_per_s,
                      found != cell.errors.end() ? found->second : std::numeric_limits<double>::quiet_NaN()});
  }
  const std::vector<bool> front = measured_front(std::move(points));
  for (std::size_t i = 0; i < front.size(); ++i) cells[i].on_front = front[i];
}

}  // namespace

firmware::Trajectory run_odometry_variant(const OdometrySet& set, const std::string& variant) {
  return run_variant(set, variant_of(set, variant)).path;
}

std::vector<OdometryCell> measure_odometry(const OdometrySet& set, const std::vector<std::uint32_t>& every,
                                           int rounds) {
  struct Work {
    std::size_t rate;
    Variant variant;
  };
  std::vector<OdometrySet> sets;
  std::vector<OdometryCell> cells;
  std::vector<Work> works;
  for (const std::uint32_t each : every) {
    sets.push_back(thinned(set, each));
    for (const char* name : kOdometryVariants) {
      const Variant variant = variant_of(set, name);
      if (!variant.changes) continue;
      OdometryCell& cell = cells.emplace_back();
      cell.set = set.name;
      cell.variant = name;
      cell.rate_hz = sets.back().rate_hz;
      const double own = set.profile_rate_hz > 0.0 ? set.profile_rate_hz : set.rate_hz;
      cell.profile_choice = cell.variant == kOdometryVariants[0] && std::fabs(cell.rate_hz - own) < 0.5;
      works.push_back({sets.size() - 1, variant});
    }
  }
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < works.size(); ++i) {
      Outcome outcome = run_variant(sets[works[i].rate], works[i].variant);
      const double cost = 1e6 * outcome.seconds / set.duration_s;
      cells[i].cost_us_per_s = round == 0 ? cost : std::min(cost, cells[i].cost_us_per_s);
      if (round > 0) continue;
      cells[i].slips = outcome.slips;
      cells[i].errors = evaluate(std::move(outcome.path), set.truth, set.evaluation).errors;
    }
  }
  mark_front(set.error, cells);
  return cells;
}

}  // namespace sortie::toolchain
