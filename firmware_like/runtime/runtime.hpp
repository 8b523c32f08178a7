// SPDX-License-Identifier: BSD-3-Clause
// One vehicle, built from one profile, in one block of memory, ready to be run.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "firmware_like/result/results.hpp"
#include "firmware_like/runtime/bus_check.hpp"
#include "firmware_like/runtime/chain_declarations.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/schedule_check.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/executive.hpp"
#include "rt/posix/live_runner.hpp"

namespace sortie::firmware {

/// Where a run begins.
struct RuntimeStart {
  rt::Nanoseconds epoch_ns{};  ///< run clock at tick 0
  InitialPose initial{};
  bool has_initial{};  ///< the log's header gives the pose; otherwise [initial] of the profile does
  std::span<const KeptMap>
      maps{};  ///< that the run begins with (kept_map.hpp); read by the constructor alone
};

/// [initial]: where the odometry's world has the robot when a run begins. Throws ProfileError.
InitialPose read_initial(Profile& profile);

/// What a scene's runs may give to the outside. Neither changes what the tasks put out.
struct RunOutlets {
  bool telemetry{true};  ///< over LCM
  bool recorder{true};   ///< into a log, where one is asked for

  SORTIE_KEYS(c, key) {
    key("telemetry", c.telemetry,
        {"a live run tells over LCM what it does, and answers requests; without it nobody can make one"});
    key("recorder", c.recorder, {"runs and replays of this scene can be recorded"});
  }
};

/// Who may change parameters, drive and fly from outside: [parameters] of the profile.
struct RequestAccess {
  bool remote{};                           ///< requests over LCM are taken
  std::string secret_file;                 ///< only from those who know the secret
  bool without_secret{};                   ///< from everybody, where there is no secret
  rt::Nanoseconds most_clock_offset_ns{};  ///< and whose clock is no farther from ours; 0: not judged
  std::string robot;                       ///< the name that the run answers by; empty: the computer's
};

/// A sealed executive with its vehicle, built into one block of memory whose unused rest is given back. After
/// construction nothing allocates on behalf of the tasks.
class Runtime {
 public:
  /// Throws ProfileError (unknown vehicle, unknown key, value out of range) or std::bad_alloc.
  Runtime(Profile profile, const VehicleRegistry& vehicles, const RuntimeStart& start);
  ~Runtime();
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  const Profile& profile() const { return profile_; }
  rt::Executive& executive() { return *executive_; }
  const rt::Executive& executive() const { return *executive_; }
  Vehicle& vehicle() { return *vehicle_; }
  const Vehicle& vehicle() const { return *vehicle_; }
  const VehicleBuilder& parts() const { return *builder_; }
  /// Changes that a run makes by itself, in order of time; each is known to be in range.
  const std::vector<ScriptLine>& script() const { return script_; }
  const RequestAccess& request_access() const { return access_; }
  const InitialPose& initial_pose() const { return builder_->initial_pose(); }
  /// How the scene wants its live runs treated.
  const rt::posix::LiveOptions& live_settings() const { return live_settings_; }
  /// What its runs give to the outside.
  const RunOutlets& outlets() const { return outlets_; }
  /// The declared table with its verdict, and the chains through it with their bounds.
  const ScheduleCheck& schedule() const { return schedule_; }
  const std::vector<DeclaredChain>& chains() const { return chains_; }
  /// The load of the CAN bus at worst; without frames for a vehicle that declares none.
  const BusCheck& bus() const { return bus_; }
  /// The whole state before the jobs of `tick`, to bytes and back into a runtime of the same profile and
  /// start. Between jobs only. A task that has not declared what it remembers is a fault of the archive.
  void archive(rt::Archive& archive, rt::Tick tick);
  /// Tasks whose state nobody has declared, or that keep it where it cannot be reached: one line each, with
  /// the cure. Empty: archive() is complete.
  std::vector<std::string> undeclared_state() const;
  /// Bytes of the memory block, to the byte; it has whole pages.
  std::size_t memory_bytes() const { return memory_bytes_; }
  /// Named pools of the block, in the order of their first use, allocations of one name summed up.
  std::vector<PoolResult> memory_plan() const;
  /// Text table of the groups: name period_us phase_us deadline_us task...
  std::string group_table() const;
  /// Text table of the tasks: name group period_us budget_us.
  std::string task_table() const;

 private:
  void build(const VehicleRegistry& vehicles, const RuntimeStart& start);
  /// Builds in a block of `mapped_bytes_`. False: that was too little.
  bool fits(const VehicleRegistry& vehicles, const RuntimeStart& start);
  void drop();
  void read_parameter_keys();

  Profile profile_;
  rt::posix::LiveOptions live_settings_;
  RunOutlets outlets_;
  ScheduleCheck schedule_;
  std::vector<DeclaredChain> chains_;
  BusCheck bus_;
  std::vector<ScriptLine> script_;
  RequestAccess access_;
  std::byte* mapping_{};
  std::size_t mapped_bytes_{};
  std::size_t memory_bytes_{};
  std::unique_ptr<rt::Arena> arena_;
  std::unique_ptr<rt::Executive> executive_;
  std::unique_ptr<VehicleBuilder> builder_;
  std::unique_ptr<Vehicle> vehicle_;
};

/// Digest, timing, pools and counters of a run that has ended. Errors, speed and warnings are the caller's to
/// add.
Results collect_results(const Runtime& runtime, std::uint64_t ticks);

}  // namespace sortie::firmware
