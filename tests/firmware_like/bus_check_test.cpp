// SPDX-License-Identifier: BSD-3-Clause
// The load of a scene's CAN bus: shown for every scene, refused where it cannot work.
#include "firmware_like/runtime/bus_check.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>
#include <string_view>

#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/profile.hpp"

using namespace sortie;
using namespace sortie::firmware;

namespace {

BusCheck bus_of(const char* scene, const std::vector<std::string>& overrides,
                std::vector<std::string>* warnings = nullptr) {
  const Runtime runtime(load_scene(scene, overrides), own_vehicles(), RuntimeStart{});
  if (warnings != nullptr) *warnings = runtime.schedule().warnings;
  return runtime.bus();
}

}  // namespace

TEST_CASE("bus check: every scene's bus has room, and every frame its bound", "[heavy]") {
  for (const BuiltInScene& scene : built_in_scenes()) {
    CAPTURE(scene.name);
    const BusCheck bus = bus_of(scene.name, {});
    const std::string_view name = scene.name;
    if (name == "building_walk" || name == "lidar_walk") {  // scans from a file, nothing on a bus
      CHECK(bus.frames.empty());
      continue;
    }
    CHECK(bus.frames.size() >= 2);
    CHECK(bus.load.share > 0.02);
    CHECK(bus.load.share < 0.8);
    for (std::size_t i = 0; i < bus.frames.size(); ++i) {
      CAPTURE(bus.frames[i].name);
      CHECK(bus.load.streams[i].worst_ns > 0);
    }
  }
}

TEST_CASE("bus check: the frames are those of the scene's protocol") {
  const auto has = [](const BusCheck& bus, std::uint32_t id) {
    return std::any_of(bus.frames.begin(), bus.frames.end(),
                       [&](const drivers::CanStream& frame) { return frame.id == id; });
  };
  const BusCheck own = bus_of("ugv_pallet", {});
  CHECK((has(own, 0x110) && has(own, 0x130) && has(own, 0x120)));
  CHECK_FALSE(has(own, 0x80));
  CHECK_FALSE(has(own, 0x101));  // nobody says that there is a button
  const BusCheck canopen = bus_of("ugv_canopen", {"emergency.button_timeout_ms=150"});
  CHECK(has(canopen, 0x101));
  CHECK((has(canopen, 0x80) && has(canopen, 0x201) && has(canopen, 0x18B) && has(canopen, 0x120)));
  CHECK_FALSE(has(canopen, 0x110));
  const BusCheck odrive = bus_of("ugv_odrive", {});
  CHECK((has(odrive, 0x02D) && has(odrive, 0x16C) && has(odrive, 0x049) && has(odrive, 0x120)));
  // Half the rate, half the load of what it is the rate of.
  const BusCheck slow = bus_of("imu_bench", {"can.imu_hz=100"});
  CHECK(slow.load.share == Approx(0.5 * bus_of("imu_bench", {}).load.share));
}

TEST_CASE("bus check: a bus that cannot carry the scene is refused with the cure, a crowded one is told") {
  CHECK_THROWS_WITH(bus_of("ugv_canopen", {"can.bitrate=125000"}), Catch::Contains("can.bitrate") &&
                                                                       Catch::Contains("% full") &&
                                                                       Catch::Contains("raise it"));
  CHECK_THROWS_WITH(bus_of("ugv_canopen", {"can.bitrate=300000"}), Catch::Contains("can.bitrate"));
  CHECK_THROWS_WITH(bus_of("ugv_canopen", {"can.bitrate=1"}), Catch::Contains("can.bitrate"));
  std::vector<std::string> warnings;
  const BusCheck crowded = bus_of("ugv_canopen", {"can.bitrate=200000", "can.imu_hz=100"}, &warnings);
  CAPTURE(crowded.load.share);
  REQUIRE(!warnings.empty());
  CHECK(warnings.back().find("still wait") != std::string::npos);
}

TEST_CASE("bus check: the table names every frame, and nothing where there is none") {
  std::ostringstream out;
  print_bus(out, bus_of("ugv_odrive", {}));
  CHECK(out.str().find("command of axis 1 ") != std::string::npos);
  CHECK(out.str().find("bit/s at worst") != std::string::npos);
  std::ostringstream empty;
  print_bus(empty, BusCheck{});
  CHECK(empty.str().empty());
}
