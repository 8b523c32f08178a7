// SPDX-License-Identifier: BSD-3-Clause
// What a pilot is told about the vehicle.
#include "tests/bench/uav/flight_senses.hpp"

#include <algorithm>
#include <cmath>

#include "hil/imu_model.hpp"
#include "tests/bench/uav/complementary.hpp"
#include "tests/bench/uav/pilot_cost.hpp"

namespace sortie::bench {

namespace {

constexpr double kStand_s = 3.0;  // at rest before the flight, for the estimator to level
constexpr rt::Nanoseconds kImuPeriod = 5 * rt::kNanosecondsPerMillisecond;

hil::ImuConfig flight_imu() { return {}; }  // an ADIS16448 at 200 Hz

rt::Nanoseconds to_ns(double time_s) { return static_cast<rt::Nanoseconds>(std::llround(time_s * 1e9)); }

// One of the estimators.
class Guide {
 public:
  explicit Guide(const FlightSetup& setup)
      : navigator_(setup.navigator),
        full_(configured(setup)),
        simple_(setup.estimator.gravity_m_s2),
        observer_(setup.estimator.disturbance) {}

  void imu(const rt::ImuSample& sample, double expected_m_s2) {
    if (navigator_ != Navigator::complementary) {
      (void)full_.imu(sample, expected_m_s2);
      state_ = full_.state();
      return;
    }
    const rt::Quaternion before = rt::to_quaternion(state_.q_world_body);
    const double dt_s = rt::to_seconds(sample.stamp_ns - state_.stamp_ns);
    simple_.imu(sample);
    state_ = simple_.state();
    const rt::Quaternion middle = rt::slerp(before, rt::to_quaternion(state_.q_world_body), 0.5);
    if (dt_s > 0.0) observer_.update(rt::to_vector(sample.acc_m_s2), middle, expected_m_s2, dt_s);
    rt::store(observer_.value_m_s2(), state_.d_world_m_s2);
  }
  void fix(const rt::UavFix& fix) {
    if (navigator_ == Navigator::complementary)
      simple_.fix(fix);
    else
      (void)full_.fix(fix);
  }
  const rt::UavState& state() const {
    return navigator_ == Navigator::complementary ? state_ : full_.state();
  }

 private:
  static estimators::UavEstimatorConfig configured(const FlightSetup& setup) {
    estimators::UavEstimatorConfig config = setup.estimator;
    if (setup.navigator == Navigator::no_acc_bias) {
      config.start_acc_bias_sigma_m_s2 = 1e-6;
      config.noise.acc_walk_m_s2_rt_s = 0.0;
    }
    return config;
  }

  Navigator navigator_;
  estimators::UavEstimator full_;
  ComplementaryFilter simple_;
  estimators::DisturbanceObserver observer_;
  rt::UavState state_;
};

}  // namespace

struct FlightSenses::Estimated {
  explicit Estimated(const FlightSetup& setup)
      : imu(flight_imu(), setup.seed), fixes(setup.fixes, setup.seed), guide(setup) {
    if (setup.dark_from_s >= 0.0)
      fixes.black_out(to_ns(kStand_s + setup.dark_from_s), to_ns(kStand_s + setup.dark_to_s));
  }
  void read(const hil::InertialTruth& truth, rt::Nanoseconds now_ns, double expected_m_s2) {
    rt::ImuSample sample;
    if (!imu.read(truth, now_ns, sample)) return;
    guide.imu(sample, expected_m_s2);
    inputs.push_back({true, sample, expected_m_s2, {}});
  }
  void fix(rt::Nanoseconds now_ns, const hil::MultirotorState& truth) {
    fixes.observe(now_ns, truth);
    rt::UavFix found;
    while (fixes.take(now_ns, found)) {
      guide.fix(found);
      inputs.push_back({false, {}, 0.0, found});
    }
  }

  struct Input {
    bool inertial;
    rt::ImuSample sample;
    double expected_m_s2;
    rt::UavFix fix;
  };
  hil::ImuModel imu;
  hil::PoseSource fixes;
  Guide guide;
  std::vector<Input> inputs;  ///< in the order in which they came
  double square{};
  long count{};
};

FlightSenses::FlightSenses(const FlightSetup& setup)
    : setup_(setup), random_(setup.seed, 0x73656e73), observer_(setup.estimator.disturbance) {
  if (setup.estimated) estimated_ = std::make_unique<Estimated>(setup);
}
FlightSenses::~FlightSenses() = default;

void FlightSenses::stand(const hil::MultirotorPlant& plant) {
  const hil::InertialTruth rest{{}, {0, 0, plant.dynamics().config().gravity_m_s2}};
  for (rt::Nanoseconds now = 0; now <= to_ns(kStand_s); now += kImuPeriod) {
    estimated_->read(rest, now, expected_m_s2_);
    estimated_->fix(now, plant.state());
  }
}

void FlightSenses::observe(hil::MultirotorPlant& plant) {
  if (estimated_ == nullptr) return;
  const rt::Nanoseconds now = to_ns(kStand_s + plant.time_s());
  if ((now + 500'000) % kImuPeriod >= 1'000'000) return;
  estimated_->read(plant.take_inertial(), now, expected_m_s2_);
  estimated_->fix(now, plant.state());
}

double FlightSenses::estimate_rms_m() const {
  return estimated_ != nullptr && estimated_->count > 0
             ? std::sqrt(estimated_->square / static_cast<double>(estimated_->count))
             : 0.0;
}

double FlightSenses::estimate_cost_us_s() const {
  if (estimated_ == nullptr) return 0.0;
  double least = 1e30;
  for (int round = 0; round < 5; ++round) {
    auto guide = std::make_unique<Guide>(setup_);
    const double before = cpu_us();
    for (const Estimated::Input& input : estimated_->inputs) {
      if (input.inertial)
        guide->imu(input.sample, input.expected_m_s2);
      else
        guide->fix(input.fix);
    }
    least = std::min(least, cpu_us() - before);
  }
  return least / (kStand_s + setup_.seconds);
}

rt::UavState FlightSenses::state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2) {
  if (estimated_ == nullptr) return true_state(plant, now_s, expected_m_s2);
  if (!started_) stand(plant);
  started_ = true;
  const rt::UavState& state = estimated_->guide.state();
  const hil::Vec3& p = plant.state().p_world_m;
  const rt::Vector3 off = rt::to_vector(state.p_world_m) - rt::Vector3{p.x, p.y, p.z};
  estimated_->square += rt::dot(off, off);
  ++estimated_->count;
  return state;
}

rt::UavState FlightSenses::true_state(hil::MultirotorPlant& plant, double now_s, double expected_m_s2) {
  const StateNoise& noise = setup_.noise;
  const auto draw = [this](double sigma) {
    const double x = random_.normal();
    const double y = random_.normal();
    const double z = random_.normal();
    return rt::Vector3{sigma * x, sigma * y, sigma * z};
  };
  const auto plain = [](const hil::Vec3& v) { return rt::Vector3{v.x, v.y, v.z}; };
  const hil::MultirotorState& truth = plant.state();
  const hil::InertialTruth inertial = plant.take_inertial();
  rt::UavState state;
  state.stamp_ns = 1 + static_cast<rt::Nanoseconds>(std::llround(now_s * 1e9));
  state.verdict = rt::UavVerdict::good;
  late_.push_back(truth.p_world_m);
  const auto delay = static_cast<std::size_t>(std::lround(setup_.position_delay_s / setup_.control.period_s));
  while (late_.size() > delay + 1) late_.pop_front();
  rt::store(plain(late_.front()) + draw(noise.position_m), state.p_world_m);
  rt::store(plain(truth.v_world_m_s) + draw(noise.velocity_m_s), state.v_world_m_s);
  const hil::Quat& q = truth.q_world_body;
  const rt::Quaternion noisy =
      rt::normalised(rt::Quaternion{q.w, q.x, q.y, q.z} * rt::exp_rotation(draw(noise.attitude_rad)));
  rt::store(noisy, state.q_world_body);
  rt::store(plain(truth.w_body_rad_s) + draw(noise.rate_rad_s), state.w_body_rad_s);
  const rt::Vector3 force = plain(inertial.acc_m_s2) + draw(noise.force_m_s2);
  if (started_ && setup_.observer) {
    observer_.update(force, rt::slerp(last_q_, noisy, 0.5), expected_m_s2, setup_.control.period_s);
    rt::store(observer_.value_m_s2(), state.d_world_m_s2);
  }
  last_q_ = noisy;
  started_ = true;
  return state;
}

}  // namespace sortie::bench
