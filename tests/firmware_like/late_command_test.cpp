// SPDX-License-Identifier: BSD-3-Clause
// What a ground robot puts on its bus when its jobs are late: nothing that moves, every stop; and a replay
// counts the same.
#include <catch2/catch.hpp>
#include <map>

#include "drivers/can_bus.hpp"
#include "drivers/can_codec.hpp"
#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

class Listener final : public drivers::CanBus {
 public:
  [[nodiscard]] Status send(const drivers::CanFrame& frame) noexcept override {
    ++frames[frame.id];
    return Status::ok;
  }
  [[nodiscard]] Status receive(drivers::CanFrame&) noexcept override { return Status::empty; }
  [[nodiscard]] drivers::CanCounters counters() const noexcept override { return {}; }
  std::map<std::uint32_t, int> frames;
};

// Every job ends in time or after its deadline, as told; its verdicts are kept, and taken again by a replay.
class Punctual final : public rt::JobFeed {
 public:
  Punctual(Runtime& runtime, bool late, const std::vector<rt::JobRecord>* recorded)
      : runtime_(runtime), late_(late), recorded_(recorded) {
    runtime.executive().set_clock([](void* self) { return static_cast<Punctual*>(self)->now_; }, this);
    runtime.executive().set_sink({this, [](void* self, const rt::JobRecord& record) {
                                    static_cast<Punctual*>(self)->kept.push_back(record);
                                  }});
  }
  void before_tick(rt::Tick tick) override {
    if (recorded_ != nullptr) return;
    Devices devices;
    devices.can = &bus;
    runtime_.vehicle().poll_devices(devices, runtime_.executive().time_of(tick));
  }
  bool prepare(std::uint32_t group, std::uint64_t job, rt::Tick, rt::JobOrder& order) override {
    const rt::Executive& executive = runtime_.executive();
    order.due_ns = executive.time_of(executive.group(group).timing.due(job));
    now_ = order.due_ns + (late_ ? 1 : -1);
    if (recorded_ != nullptr) order = {&(*recorded_)[next_++]};
    return true;
  }

  Listener bus;
  std::vector<rt::JobRecord> kept;

 private:
  Runtime& runtime_;
  bool late_;
  const std::vector<rt::JobRecord>* recorded_;
  std::size_t next_{};
  rt::Nanoseconds now_{};
};

std::uint64_t count_of(const Runtime& runtime, const std::string& name) {
  return collect_results(runtime, 0).counters.at(name);
}

}  // namespace

TEST_CASE("late jobs move nothing: their commands are dropped and counted, their stops leave") {
  constexpr rt::Tick kEnd = 500;
  for (const bool late : {false, true}) {
    // Nobody tells the robot anything, so it stands; its flippers are held where they are wanted.
    Runtime live(load_scene("ugv_pallet"), own_vehicles(), RuntimeStart{});
    Punctual feed(live, late, nullptr);
    rt::run_virtual(live.executive(), feed, 0, kEnd);
    INFO("late: " << late);
    CHECK(feed.bus.frames[drivers::kCanDriveId] >= 40);
    CHECK((feed.bus.frames[drivers::kCanFlipperFrontId] == 0) == late);
    CHECK((count_of(live, "drive_late_stops") >= 40) == late);
    CHECK(count_of(live, "drive_late") == 0);
    CHECK((count_of(live, "flippers_late") >= 20) == late);
    CHECK(count_of(live, "missed_jobs") == (late ? feed.kept.size() : 0));

    Runtime again(load_scene("ugv_pallet"), own_vehicles(), RuntimeStart{});
    Punctual replay(again, !late, &feed.kept);
    rt::run_virtual(again.executive(), replay, 0, kEnd);
    for (const char* name : {"drive_late", "drive_late_stops", "flippers_late", "flippers_late_stops"})
      CHECK(count_of(again, name) == count_of(live, name));
    CHECK(again.executive().digest() == live.executive().digest());

    // So does one that goes on from a keyframe.
    rt::Archive measure = rt::Archive::measuring();
    live.executive().archive(measure, kEnd);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
    rt::Archive write = rt::Archive::writing(bytes);
    live.executive().archive(write, kEnd);
    REQUIRE(write.status() == Status::ok);
    Runtime onward(load_scene("ugv_pallet"), own_vehicles(), RuntimeStart{});
    rt::Archive read = rt::Archive::reading(bytes);
    onward.executive().archive(read, kEnd);
    REQUIRE(read.status() == Status::ok);
    for (const char* name : {"drive_late", "drive_late_stops", "flippers_late", "flippers_late_stops"})
      CHECK(count_of(onward, name) == count_of(live, name));
  }
}
