// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/live/truth_writer.hpp"

#include "drivers/wire_truth.hpp"

namespace sortie::firmware {

namespace {
constexpr rt::Nanoseconds kPoseEvery = 10 * rt::kNanosecondsPerMillisecond;
}

void TruthWriter::note(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink* sink) {
  note_contacts(robot, now_ns, sink);
  if (sink != nullptr) note_sensors(robot, now_ns, *sink);
  const rt::TruthSample sample = robot.truth();
  if (sample.flags == 0 || sample.stamp_ns < next_pose_ns_) return;
  next_pose_ns_ = sample.stamp_ns + kPoseEvery;
  poses.add(to_timed_pose(sample));
  if (sink == nullptr) return;
  std::uint8_t message[drivers::kTruthBytes];
  std::size_t size = 0;
  if (drivers::encode(sample, message, size) == Status::ok)
    sink->sample(std::string(drivers::kChannelTruth), now_ns, {message, size});
}

void TruthWriter::note_sensors(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink& sink) {
  rt::SensorTruth truth;
  if (!robot.sensors(truth) || truth.stamp_ns == last_sensors_ns_) return;
  last_sensors_ns_ = truth.stamp_ns;
  std::uint8_t message[drivers::kMaxSensorTruthBytes];
  std::size_t size = 0;
  if (drivers::encode(truth, sensor_records_++, message, size) == Status::ok)
    sink.sample(std::string(drivers::kChannelSensorTruth), now_ns, {message, size});
}

void TruthWriter::note_contacts(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink* sink) {
  const rt::Nanoseconds every_ns = robot.contacts_every_ns();
  if (every_ns <= 0 || now_ns < next_contacts_ns_) return;
  rt::ContactTruth truth;
  if (!robot.contacts(truth) || truth.stamp_ns < next_contacts_ns_) return;
  next_contacts_ns_ = truth.stamp_ns + every_ns;
  contacts.add(summarise(truth));
  contacts_dropped += truth.dropped;
  if (sink == nullptr) return;
  std::uint8_t message[drivers::kMaxContactsBytes];
  std::size_t size = 0;
  if (drivers::encode(truth, message, size) == Status::ok)
    sink->sample(std::string(drivers::kChannelContacts), now_ns, {message, size});
}

}  // namespace sortie::firmware
