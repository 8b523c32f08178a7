// SPDX-License-Identifier: BSD-3-Clause
// What a task remembers beside its output belongs into keyframes, and the vehicle has to say so.
#include <catch2/catch.hpp>
#include <memory>

#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// Remembers a number beside its output; what it says of that is chosen.
enum class Says { nothing, all, that_there_is_none, captured };
class Counting final : public Vehicle {
 public:
  Counting(VehicleBuilder& builder, Says says) {
    const rt::GroupId group = builder.group("count", 100);
    const auto step = [this](rt::JobContext& context, Mixed& out) { out.sum = hidden_ += context.job; };
    const rt::TaskBase* task =
        says == Says::captured
            ? builder.task<Mixed>(group, "count", 10,
                                  [sum = std::uint64_t{}](rt::JobContext& context, Mixed& out) mutable {
                                    out.sum = sum += context.job;
                                  })
            : builder.task<Mixed>(group, "count", 10, step);
    if (says == Says::all) builder.remembers(task, hidden_);
    if (says == Says::that_there_is_none || says == Says::captured) builder.remembers(task);
  }

 private:
  std::uint64_t hidden_{};
};

VehicleRegistry counting(Says says) {
  return {{"counting", [says](VehicleBuilder& builder) -> std::unique_ptr<Vehicle> {
             return std::make_unique<Counting>(builder, says);
           }}};
}

}  // namespace

TEST_CASE("state that a vehicle does not declare is refused if it can be known and noticed if it cannot") {
  const TempFolder folder;
  const std::string scene = folder.write("c.toml", "[scene]\nname = \"c\"\nvehicle = \"counting\"\n");
  const std::string log = folder.file("c.lcm");
  LiveRunOptions live;
  live.scene = scene;
  live.seconds = 1;
  live.realtime = false;
  live.record = log;
  live.lcm_url = "none";
  static_cast<void>(run_live_undisturbed(counting(Says::all), nullptr, live));

  const auto undeclared = [&](Says says) {
    const Runtime runtime(load_scene(scene), counting(says), RuntimeStart{});
    const auto lines = runtime.undeclared_state();
    return lines.empty() ? std::string() : lines.front();
  };
  CHECK(undeclared(Says::all).empty());
  CHECK(mentions(undeclared(Says::nothing), "task count"));
  CHECK(mentions(undeclared(Says::nothing), "remembers(task"));
  CHECK(mentions(undeclared(Says::captured), "captures"));
  CHECK(undeclared(Says::that_there_is_none).empty());
  CHECK(mentions(message_of<InputError>(
                     [&] { static_cast<void>(replay_and_keep(log, counting(Says::nothing), {}, 100)); }),
                 "declared"));

  ReplayOptions options;
  options.from = "0.5";
  for (const Says says : {Says::all, Says::that_there_is_none}) {
    const Indexed full = replay_and_keep(log, counting(says), {}, 100, keyframe_path(log));
    REQUIRE_FALSE(full.outcome.divergence.has_value());
    const ReplayOutcome part = replay(LogFile(log), counting(says), options);
    CHECK(part.restored_tick == 500);
    CHECK(part.divergence.has_value() == (says == Says::that_there_is_none));
  }
}
