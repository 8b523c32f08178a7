// SPDX-License-Identifier: BSD-3-Clause
// What a run tells bears one date on every channel, whatever the system's clock says meanwhile.
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>

#include "drivers/lcm_receiver.hpp"
#include "firmware_like/link/telemetry.hpp"
#include "firmware_like/live/live_run.hpp"
#include "rt/posix/clock.hpp"
#include "rt/virtual_runner.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

class EveryRelease final : public rt::JobFeed {
 public:
  bool prepare(std::uint32_t, std::uint64_t, rt::Tick, rt::JobOrder&) override { return true; }
};

// The messages' first field, on all channels that dates are told on: `int64_t utime`, behind the fingerprint.
std::int64_t utime_of(std::span<const std::uint8_t> message) {
  std::uint64_t value = 0;
  for (std::size_t i = 8; i < 16; ++i) value = value << 8 | message[i];
  return static_cast<std::int64_t>(value);
}

}  // namespace

TEST_CASE("every event of a live run's log has a date of that run") {
  const TempFolder folder;
  stalls = {};
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.seconds = 0.3;
  options.realtime = false;
  options.record = folder.file("live.lcm");
  options.lcm_url = "none";
  static_cast<void>(run_live(stall_vehicles(), nullptr, options));
  const LogFile log(options.record);
  std::set<std::string> kinds;
  for (const StoredEvent& stored : log.channel(std::string(drivers::kChannelEvent))) {
    drivers::EventRecord event;
    REQUIRE(drivers::decode(stored.message, event) == Status::ok);
    INFO(event.kind);
    CHECK(event.utime >= log.header().utc_minus_monotonic_ns / 1000);
    CHECK(event.utime < log.header().utc_minus_monotonic_ns / 1000 + 60'000'000);
    kinds.insert(event.kind);
  }
  for (const char* kind : {"clock", "doctor", "end", "measured"}) CHECK(kinds.count(kind) == 1);
}

TEST_CASE("when the system's clock was set after the start, all channels keep the date of the start") {
  const std::string url = "udpm://239.255.76.68:7718?ttl=0";
  drivers::LcmReceiver receiver(url);
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=32768"}), own_vehicles(), RuntimeStart{});
  LogRecorder recorder(runtime, {}, make_header(runtime, "test", 0));
  const RequestDoor desk(runtime);
  rt::Nanoseconds start_ns = rt::posix::monotonic_now();
  runtime.executive().set_clock(
      [](void* self) { return rt::posix::monotonic_now() - *static_cast<rt::Nanoseconds*>(self); },
      &start_ns);
  EveryRelease feed;
  rt::run_virtual(runtime.executive(), feed, 0, 300);

  // The run began by a clock that was an hour ahead of what it is now.
  constexpr rt::Nanoseconds kHour = 3600 * rt::kNanosecondsPerSecond;
  const rt::Nanoseconds utc_minus_run = rt::posix::utc_minus_monotonic() + start_ns + kHour;
  Telemetry telemetry(runtime, recorder, desk, url, utc_minus_run);
  if (!telemetry.problem().empty()) {
    WARN("skipped: " << telemetry.problem());
    return;
  }
  telemetry.start();
  std::map<std::string, std::int64_t> dates;
  const auto heard_all = [&dates] {
    for (const char* channel : {"SORTIE_STATS", "SORTIE_POOLS", "POSE_BODY"})
      if (dates.count(channel) == 0) return false;
    return dates.size() >= 5;
  };
  for (int i = 0; i < 400 && !heard_all(); ++i) {
    drivers::ReceivedMessage received;
    if (receiver.receive(received, 20) != Status::ok || received.message.payload.size() < 16) continue;
    dates[std::string(received.message.channel)] = utime_of(received.message.payload);
  }
  telemetry.stop();
  CHECK(heard_all());
  for (const auto& [channel, date_us] : dates) {
    INFO(channel);
    const std::int64_t wanted = utc_minus_run / 1000;
    CHECK(date_us >= wanted);
    CHECK(date_us < wanted + 60'000'000);
  }
}
