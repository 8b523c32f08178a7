// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/attitude/attitude_sweep.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <stdexcept>

#include "estimators/attitude.hpp"
#include "tests/bench/vqf_peer.hpp"

namespace sortie::bench {

namespace {

using rt::Quaternion;
using rt::Vector3;

constexpr double kDegrees = 57.29577951308232;
constexpr std::uint32_t kFine_hz = 2000;
constexpr double kDuration_s = 120;

// One pass: errors and time.
template <class Update>
void pass(const AttitudeSet& set, AttitudeRow& row, Update update) {
  double tilt = 0;
  double heading = 0;
  double first = 0;
  double n = 0;
  bool aligned = false;
  std::chrono::nanoseconds spent{};
  constexpr std::size_t kBatch = 64;  // judged in between, outside the time
  Quaternion found[kBatch];
  for (std::size_t from = 0; from < set.samples.size(); from += kBatch) {
    const std::size_t to = std::min(from + kBatch, set.samples.size());
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t i = from; i < to; ++i) found[i - from] = update(set.samples[i].sample);
    spent += std::chrono::steady_clock::now() - begin;
    for (std::size_t i = from; i < to; ++i) {
      if (!set.samples[i].known) continue;
      const Quaternion error = found[i - from] * conjugate(set.samples[i].truth);
      const double turn = 2 * rt::atan2(error.z, error.w);
      if (!aligned) first = turn;
      aligned = true;
      if (!set.samples[i].judged) continue;
      const double lean = 2 * rt::atan2(std::hypot(error.x, error.y), std::hypot(error.w, error.z));
      tilt += lean * lean;
      heading += std::pow(rt::wrap_angle(turn - first), 2);
      n += 1;
    }
  }
  const double ns = static_cast<double>(spent.count()) / static_cast<double>(set.samples.size());
  row.ns = row.ns > 0 ? std::min(row.ns, ns) : ns;
  row.inclination_deg = kDegrees * std::sqrt(tilt / n);
  row.heading_deg = kDegrees * std::sqrt(heading / n);
}

template <class Filter>
void run_own(const AttitudeSet& set, const estimators::AttitudeConfig& config, AttitudeRow& row) {
  Filter filter{config};
  pass(set, row, [&](const rt::ImuSample& sample) {
    static_cast<void>(filter.update(sample));
    return rt::to_quaternion(filter.estimate().q_world_body);
  });
}

void run_once(const std::string& variant, const AttitudeSet& set, AttitudeRow& row) {
  estimators::AttitudeConfig config;
  if (variant == "VQF") {
    VqfPeer peer(1 / set.rate_hz);
    pass(set, row, [&](const rt::ImuSample& sample) {
      const double* w = sample.gyr_rad_s;
      const double* f = sample.acc_m_s2;
      peer.update({w[0], w[1], w[2]}, {f[0], f[1], f[2]});
      const VqfPeer::Quaternion q = peer.attitude();
      return Quaternion{q[0], q[1], q[2], q[3]};
    });
    return;
  }
  if (variant == "float") {
    run_own<estimators::AttitudeFloat>(set, config, row);
    return;
  }
  if (variant == "no coning") {
    config.coning = false;
  } else if (variant == "no bias filter") {
    config.bias_sigma_initial_rad_s = 0;
  } else if (variant == "heading does not follow the bias") {
    config.heading_follows_bias = false;
  } else if (variant == "a block each sample") {
    config.block_ns = 1;
  } else if (variant != "double") {
    throw std::invalid_argument("no such variant: " + variant);
  }
  run_own<estimators::Attitude>(set, config, row);
}

}  // namespace

std::vector<AttitudeRow> measure_attitude(const AttitudeSet& set, int rounds) {
  std::vector<AttitudeRow> rows;
  for (const char* variant : kAttitudeVariants) rows.push_back({set.name, variant, set.rate_hz, 0, 0, 0});
  for (int round = 0; round < rounds; ++round) {
    for (AttitudeRow& row : rows) run_once(row.variant, set, row);
  }
  return rows;
}

AttitudeSet simulate_attitude(std::uint32_t rate_hz) {
  std::mt19937 random(17);
  const auto noise3 = [&random](double sigma) {
    double v[3];
    for (double& part : v) {
      part = -6;
      for (int i = 0; i < 12; ++i) part += static_cast<double>(random() % 65536u) / 65536.0;
    }
    return sigma * rt::to_vector(v);
  };
  constexpr double kGyr_rad_s_rthz = 0.0002;
  constexpr double kAcc_m_s2_rthz = 0.002;
  const Vector3 bias{0.004, -0.003, 0.002};
  const std::uint32_t parts = kFine_hz / rate_hz;
  AttitudeSet set{"simulated", static_cast<double>(rate_hz), {}};
  Quaternion q;
  Vector3 rate;
  Vector3 force;
  for (std::uint32_t i = 1; i <= static_cast<std::uint32_t>(kDuration_s * kFine_hz); ++i) {
    const double t = i / static_cast<double>(kFine_hz);
    const double shake = t < 5 ? 0 : 1;
    const auto wave = [t, shake](double size, double hz, double phase) {
      return shake * size * rt::sincos(6.283185307179586 * hz * t + phase).sin;
    };
    const Vector3 w{wave(0.8, 0.3, 0) + wave(1.0, 11, 0), wave(0.6, 0.5, 1) + wave(1.0, 11, 1.3),
                    wave(0.7, 0.13, 2)};
    const Vector3 a{wave(3, 1.1, 0), wave(2, 0.9, 1), wave(2, 2.3, 0)};
    q = normalised(q * exp_rotation((1.0 / kFine_hz) * w));
    const double root = std::sqrt(static_cast<double>(kFine_hz));
    rate = rate + w + bias + noise3(kGyr_rad_s_rthz * root);
    force = force + rotate_back(q, a + Vector3{0, 0, 9.81}) + noise3(kAcc_m_s2_rthz * root);
    if (i % parts != 0) continue;
    JudgedSample judged;
    judged.sample.stamp_ns = static_cast<rt::Nanoseconds>(i) * (rt::kNanosecondsPerSecond / kFine_hz);
    rt::store((1.0 / parts) * rate, judged.sample.gyr_rad_s);
    rt::store((1.0 / parts) * force, judged.sample.acc_m_s2);
    judged.sample.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
    judged.truth = q;
    judged.known = true;
    judged.judged = t >= 5;
    set.samples.push_back(judged);
    rate = force = {};
  }
  return set;
}

AttitudeSet thinned(const AttitudeSet& set, std::uint32_t every) {
  AttitudeSet out{set.name, set.rate_hz / every, {}};
  for (std::size_t i = 0; i + every <= set.samples.size(); i += every) {
    JudgedSample sum = set.samples[i + every - 1];
    Vector3 rate;
    Vector3 force;
    for (std::size_t k = i; k < i + every; ++k) {
      rate = rate + rt::to_vector(set.samples[k].sample.gyr_rad_s);
      force = force + rt::to_vector(set.samples[k].sample.acc_m_s2);
    }
    rt::store((1.0 / every) * rate, sum.sample.gyr_rad_s);
    rt::store((1.0 / every) * force, sum.sample.acc_m_s2);
    out.samples.push_back(sum);
  }
  return out;
}

}  // namespace sortie::bench
