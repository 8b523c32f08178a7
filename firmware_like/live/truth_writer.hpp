// SPDX-License-Identifier: BSD-3-Clause
// What a simulated robot knows about itself, on its way to a log and to the result of a run; never to a task.
#pragma once

#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/log/timed_pose.hpp"

namespace sortie::firmware {

/// Notes the truth after each step of the robot: the pose every 10 ms, contacts as often as the robot says,
/// sensors with each IMU sample. One thread. What is kept is bounded, however long the run.
class TruthWriter {
 public:
  /// `sink`: where messages go, or null.
  void note(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink* sink);

  BoundedTrajectory poses{1};
  BoundedSeries<ContactSummary> contacts{1, std::size_t{1} << 17};
  std::uint64_t contacts_dropped{};  ///< in what was noted: beyond the list of a record

 private:
  void note_sensors(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink& sink);
  void note_contacts(const SimulatedRobot& robot, rt::Nanoseconds now_ns, SampleSink* sink);

  rt::Nanoseconds next_pose_ns_{};
  rt::Nanoseconds next_contacts_ns_{};
  rt::Nanoseconds last_sensors_ns_{};
  std::int64_t sensor_records_{};
};

}  // namespace sortie::firmware
