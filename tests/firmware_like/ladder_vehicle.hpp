// SPDX-License-Identifier: BSD-3-Clause
// A vehicle with all that a job can be told to leave out: levels of the ladder, work units, cuts, missed
// deadlines. Its run is on an invented clock, so that each of these comes in each run and at the same job.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware_like/log/log_recorder.hpp"
#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

namespace sortie::testing {

/// The clock of the run; tasks let it pass. A replay has a clock of its own.
inline thread_local rt::Nanoseconds invented_ns = 0;

/// Groups `work` (tasks steer, refine of criticality B with units, extra of criticality C), `plan` and
/// `shown`. `plan` reads `work`; nobody reads `shown`.
class LadderVehicle final : public firmware::Vehicle {
 public:
  static constexpr std::uint32_t kUnits = 40;
  static constexpr rt::Nanoseconds kUnitNs = 10'000;

  explicit LadderVehicle(firmware::VehicleBuilder& builder) {
    const rt::GroupId work = builder.group("work", 1000);
    const rt::GroupId plan = builder.group("plan", 100);
    const rt::GroupId shown = builder.group("shown", 50);
    std::tie(stream_, port_) = builder.stream<Reading>(work, "SORTIE_CUSTOM_work", 64, 16);
    steer_ = builder.task<Mixed>(work, "steer", 200, [this](rt::JobContext& context, Mixed& mixed) {
      for (const Reading& reading : *stream_) mixed.sum = mixed.sum * 31 + reading.value;
      mixed.sum += context.job;
      if (context.job % 11 == 3) invented_ns += 2'000'000;  // later than the deadline
    });
    builder.task<Mixed>(work, "refine",
                        {.budget_us = 500, .criticality = rt::Criticality::b, .units = kUnits},
                        [](rt::JobContext& context, Mixed& mixed) {
                          // Every third job is content before its units end.
                          const std::uint32_t most = context.job % 3 == 0 ? 12 : 1000;
                          for (std::uint32_t i = 0; i < most && context.spend(); ++i) {
                            mixed.sum = mixed.sum * 7 + i;
                            invented_ns += kUnitNs;
                          }
                        });
    builder.task<Mixed>(work, "extra", {.budget_us = 100, .criticality = rt::Criticality::c},
                        [](rt::JobContext& context, Mixed& mixed) { mixed.sum += context.job; });
    const auto follow = [](const rt::JobContext& context, const rt::Input<Mixed>& input, Mixed& mixed) {
      for (const Mixed& other : input) mixed.sum = mixed.sum * 37 + other.sum;
      mixed.sum += context.job;
      if (context.job % 7 == 4) invented_ns += 30'000'000;
    };
    rt::Task<Mixed>* const planner = builder.task<Mixed>(
        plan, "planner", 300,
        [this, follow](rt::JobContext& context, Mixed& mixed) { follow(context, *plan_input_, mixed); });
    builder.task<Mixed>(shown, "picture", 300, [this, follow](rt::JobContext& context, Mixed& mixed) {
      follow(context, *shown_input_, mixed);
    });
    plan_input_ = builder.input(plan, steer_, 16);
    shown_input_ = builder.input(shown, planner, 4);
    builder.check();
  }

  void poll_devices(const firmware::Devices&, rt::Nanoseconds now_ns) override {
    static_cast<void>(port_->push({now_ns, ++next_}, now_ns));
  }

 private:
  rt::Stream<Reading>* stream_{};
  firmware::InputPort<Reading>* port_{};
  rt::Task<Mixed>* steer_{};
  rt::Input<Mixed>* plan_input_{};
  rt::Input<Mixed>* shown_input_{};
  std::uint32_t next_{};
};

inline firmware::VehicleRegistry ladder_vehicles() {
  return {{"ladder", [](firmware::VehicleBuilder& builder) -> std::unique_ptr<firmware::Vehicle> {
             return std::make_unique<LadderVehicle>(builder);
           }}};
}

/// A recorded run of the vehicle: each level for 30 ticks in turn, every fifth job guarded after 15 units.
class LadderRun final : public rt::JobFeed {
 public:
  explicit LadderRun(const TempFolder& folder, rt::Tick ticks = 600)
      : log(folder.file("ladder.lcm")),
        runtime_(firmware::load_scene(
                     folder.write("ladder.toml", "[scene]\nname = \"ladder\"\nvehicle = \"ladder\"\n")),
                 ladder_vehicles(), firmware::RuntimeStart{}) {
    firmware::RecorderOptions options;
    options.path = log;
    options.on_job = [this](const rt::JobRecord& record) { jobs.push_back(record); };
    // With an offset to UTC: the times in the log are those of the run.
    firmware::LogRecorder recorder(runtime_, options, firmware::make_header(runtime_, "test", 1));
    recorder_ = &recorder;
    for (const auto& port : runtime_.parts().ports()) port->set_sink(&recorder);
    rt::Executive& executive = runtime_.executive();
    executive.set_sink(recorder.job_sink());
    executive.set_clock([](void*) { return invented_ns; }, nullptr);
    rt::run_virtual(executive, *this, 0, ticks - 1);
    recorder.stop();
    digest = executive.digest();
  }

  const rt::Executive& executive() { return runtime_.executive(); }

  std::string log;
  std::vector<rt::JobRecord> jobs;  ///< as the executive gave them, in the order of the log
  std::uint64_t digest{};

 private:
  void before_tick(rt::Tick tick) override {
    invented_ns = runtime_.executive().time_of(tick);
    runtime_.vehicle().poll_devices({}, invented_ns);
    if (tick % 20 == 0) recorder_->drain();
  }
  bool prepare(std::uint32_t group, std::uint64_t job, rt::Tick tick, rt::JobOrder& order) override {
    const rt::Executive& executive = runtime_.executive();
    invented_ns = executive.time_of(tick);
    order.due_ns = executive.time_of(executive.group(group).timing.due(job));
    order.level = static_cast<std::uint8_t>(tick / 30 % rt::kLevels);
    if (job % 5 == 0) order.guard_ns = invented_ns + 15 * LadderVehicle::kUnitNs;
    return true;
  }

  firmware::Runtime runtime_;
  firmware::LogRecorder* recorder_{};
};

}  // namespace sortie::testing
