// SPDX-License-Identifier: BSD-3-Clause
// What moves around the executive in a run: the simulated robot, the devices, scripted changes.
#pragma once

#include "firmware_like/link/plant_link.hpp"
#include "firmware_like/link/request_door.hpp"
#include "firmware_like/live/simulated_robot.hpp"
#include "firmware_like/live/truth_writer.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/log/timed_pose.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "rt/virtual_runner.hpp"

namespace sortie::firmware {

/// Picks a task's pose out of the fields of each job: the task's value itself belongs to its worker.
template <class Output>
class TaskPoses {
 public:
  /// `whose` may be null.
  TaskPoses(const Runtime& runtime, const rt::Task<Output>* whose) : task_(whose) {
    if (task_ == nullptr) return;
    for (const rt::TaskBase* task : runtime.executive().group(task_->group()).tasks) {
      if (task == task_) break;
      offset_ += task->output_bytes();
    }
  }
  void job(const rt::JobRecord& record) {
    if (task_ == nullptr || record.group != task_->group() ||
        record.field_bytes < offset_ + task_->output_bytes())
      return;
    Output pose;
    rt::decode_canonical(record.fields + offset_, pose);
    const TimedPose timed = to_timed_pose(pose);
    if (timed.stamp_ns != 0) poses.add(timed);
  }
  BoundedTrajectory poses{1};

 private:
  const rt::Task<Output>* task_;
  std::uint32_t offset_{};
};

/// Trajectories of a run.
class PoseCollector {
 public:
  explicit PoseCollector(const Runtime& runtime)
      : estimate(runtime, runtime.vehicle().pose_task()),
        located(runtime, runtime.vehicle().located_task()) {}
  void job(const rt::JobRecord& record) {
    estimate.job(record);
    located.job(record);
  }
  TaskPoses<rt::PoseEstimate> estimate;
  TaskPoses<rt::LocatedPose> located;
};

/// Everything around the executive that moves between ticks: the simulated robot, the devices, the truth.
class Surroundings {
 public:
  /// `robot`: null unless one is simulated in this process. `link`: to a plant in another one, or null.
  Surroundings(SimulatedRobot* robot, const Devices& devices, PlantLink* link, LogRecorder& recorder)
      : robot_(robot), recorder_(recorder), link_(link), devices_(devices) {}
  /// Moves the simulated robot, if there is one, and notes its truth.
  void step_robot(rt::Nanoseconds now) {
    if (robot_ == nullptr) return;
    robot_->step(now);
    truth.note(*robot_, now, &recorder_);
  }
  /// What the vehicle reaches its devices by.
  const Devices& devices() const { return devices_; }
  /// To a plant in a process of its own, or null.
  PlantLink* link() const { return link_; }
  TruthWriter truth;

 private:
  SimulatedRobot* robot_;
  LogRecorder& recorder_;
  PlantLink* link_;
  Devices devices_;
};

/// Everything around the executive, moved between the ticks of a virtual run.
class SimulatedFeed final : public rt::JobFeed {
 public:
  SimulatedFeed(Surroundings& surroundings, Runtime& runtime, LogRecorder& recorder, RequestDoor& desk)
      : surroundings_(surroundings), runtime_(runtime), recorder_(recorder), desk_(desk) {}
  void before_tick(rt::Tick tick) override {
    const rt::Nanoseconds now = runtime_.executive().time_of(tick);
    surroundings_.step_robot(now);
    runtime_.vehicle().poll_devices(surroundings_.devices(), now);
    desk_.run_script(now);
    if (tick % 64 == 0) recorder_.drain();
  }
  bool prepare(std::uint32_t, std::uint64_t, rt::Tick, rt::JobOrder&) override { return true; }

 private:
  Surroundings& surroundings_;
  Runtime& runtime_;
  LogRecorder& recorder_;
  RequestDoor& desk_;
};

}  // namespace sortie::firmware
