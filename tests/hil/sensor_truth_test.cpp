// SPDX-License-Identifier: BSD-3-Clause
// The truth beside IMU and encoders: it is what they show when nothing is wrong with them, and what they lack
// otherwise.
#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/wire_truth.hpp"
#include "rt/digest.hpp"
#include "tests/hil/ugv_bench.hpp"

namespace sortie::hil {

TEST_CASE("sensor truth: readings less bias and noise are the truth, sample by sample") {
  UgvConfig config;
  config.imu.gyr_noise_rad_s_rt_hz = config.imu.acc_noise_m_s2_rt_hz = 0.0;
  config.imu.gyr_bias_rad_s = 0.05;
  config.imu.acc_bias_m_s2 = 0.5;
  config.imu.gyr_walk_rad_s_rt_s = 1e-3;
  config.imu.lever_arm_m[0] = 0.2;
  UgvBench bench(config);
  int compared = 0;
  rt::SensorTruth before;  // a frame arrives in a later step than it was sent in
  for (int i = 0; i < 3000; ++i) {
    if (i % 20 == 0) bench.command(0.4, 0.2);
    bench.step([&](const drivers::CanFrame& frame) {
      drivers::CanSample sample;
      const bool is_imu =
          bench.decoder.decode(frame, sample) == Status::ok && sample.kind == drivers::CanSampleKind::imu;
      if (!is_imu || before.stamp_ns == 0 || std::abs(sample.imu.stamp_ns - before.stamp_ns) > 10'000) return;
      ++compared;
      for (int k = 0; k < 3; ++k) {  // half a step of the frames' numbers
        CHECK(std::abs(sample.imu.gyr_rad_s[k] - before.gyr_rad_s[k] - before.gyr_bias_rad_s[k]) < 3e-4);
        CHECK(std::abs(sample.imu.acc_m_s2[k] - before.acc_m_s2[k] - before.acc_bias_m_s2[k]) < 3e-3);
      }
    });
    before = bench.plant->sensor_truth();
  }
  CHECK(compared > 400);
}

TEST_CASE("sensor truth: belts less ground is slip, and the ground follows the pose") {
  UgvConfig config;
  config.robot.slip_left = 0.1;
  config.robot.slip_right = 0.0;
  config.robot.steering_efficiency = 1.0;
  config.hall.ramp_height_m = 0.0;
  UgvBench bench(config);
  bench.run(8000, [&](int) { bench.command(0.3, 0.3); });
  const rt::SensorTruth& truth = bench.plant->sensor_truth();
  CHECK(truth.belt_left_m > 2.0);
  CHECK(truth.ground_left_m == Approx(0.9 * truth.belt_left_m).epsilon(2e-3));
  CHECK(truth.ground_right_m == Approx(truth.belt_right_m).epsilon(2e-3));
  // The difference of both ways is the track distance times the heading.
  const Quat& q = bench.plant->motion().q_world_body;
  const double yaw = 2.0 * std::atan2(q.z, q.w);
  CHECK(truth.ground_right_m - truth.ground_left_m ==
        Approx(config.robot.track_distance_m * yaw).epsilon(1e-6));
}

TEST_CASE("sensor truth: the message carries every number, and another one is refused") {
  rt::SensorTruth truth;
  truth.stamp_ns = 5;
  truth.acc_bias_m_s2[2] = -0.25;
  truth.ground_right_m = 7.5;
  std::uint8_t message[drivers::kMaxSensorTruthBytes];
  std::size_t size = 0;
  REQUIRE(drivers::encode(truth, 3, message, size) == Status::ok);
  rt::SensorTruth read;
  REQUIRE(drivers::decode({message, size}, read) == Status::ok);
  CHECK(rt::digest_of(read) == rt::digest_of(truth));
  // The list of fields in the message is that of the struct.
  std::string fields;
  rt::for_each_scalar(truth, [&fields](const char* name, int index, auto scalar) {
    fields +=
        std::string(fields.empty() ? "" : ",") + name + (index < 0 ? "" : "[" + std::to_string(index) + "]");
    fields += std::is_floating_point_v<decltype(scalar)> ? ":f64" : ":i64";
  });
  CHECK(fields == drivers::kSensorTruthFields);
  for (std::size_t cut = 0; cut < size; ++cut) CHECK(drivers::decode({message, cut}, read) != Status::ok);
  message[60] ^= 1;  // a letter of a field's name
  CHECK(drivers::decode({message, size}, read) == Status::malformed);
  CHECK(drivers::encode(truth, 3, std::span(message).first(100), size) == Status::full);
}

}  // namespace sortie::hil
