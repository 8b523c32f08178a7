// SPDX-License-Identifier: BSD-3-Clause
// A scene's CAN bus is worked out when it is loaded: shown, and refused where it is too full.
#include "firmware_like/bus_load.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

namespace {

std::string bus_error(const char* scene, const std::vector<std::string>& overrides) {
  return sortie::testing::message_of<sortie::firmware::ProfileError>([&] {
    const sortie::firmware::Runtime runtime(sortie::firmware::load_scene(scene, overrides),
                                            sortie::firmware::own_vehicles(),
                                            sortie::firmware::RuntimeStart{});
  });
}

sortie::firmware::BusLoad bus_of(const char* scene, const std::vector<std::string>& overrides = {}) {
  const sortie::firmware::Runtime runtime(sortie::firmware::load_scene(scene, overrides),
                                          sortie::firmware::own_vehicles(), sortie::firmware::RuntimeStart{});
  return runtime.parts().bus();
}

}  // namespace

TEST_CASE("the bus of six CANopen drives is as full as its frames counted by hand") {
  const sortie::firmware::BusLoad bus = bus_of("ugv_canopen");
  // 100 SYNCs of 55 bits, 6 drives with 100 commands of 115 and 100 answers of 135, 7 heartbeats of 65 at 20
  // Hz, 400 frames of the IMU of 135: of 500000.
  const double bits = 100 * 55 + 600 * (115 + 135) + 7 * 20 * 65 + 400 * 135;
  CHECK(bus.streams.size() == 1 + 12 + 7 + 2);
  CHECK(bus.load.share == Approx(bits / 500'000));
  for (const auto& stream : bus.load.streams) CHECK(stream.worst_ns > 0);
  std::ostringstream text;
  print_bus(text, bus);
  INFO(text.str());
  CHECK(sortie::testing::mentions(text.str(), "500000 bit/s, at worst 43.7 % full, 80.0 % allowed"));
  CHECK(to_json(bus)["frames"][0]["name"] == "sync");
  CHECK(bus_of("ugv_hall").load.share == Approx((400 * 135 + 200 * 115 + 100 * 115) / 500'000.0));
}

TEST_CASE("a bus that is too full, or too slow for one of its frames, is refused with figures and cures") {
  using sortie::testing::mentions;
  CHECK(bus_error("ugv_canopen", {}).empty());
  const std::string full = bus_error("ugv_canopen", {"can.max_load_percent=43"});
  INFO(full);
  CHECK(mentions(full, "can.max_load_percent"));
  CHECK(mentions(full, "43.7 % of the bus, above the allowed 43.0 %"));
  CHECK(mentions(bus_error("ugv_canopen", {"can.bitrate=125000"}), "fill 174"));
  const std::string late = bus_error(
      "ugv_hall", {"can.bitrate=50000", "can.imu_hz=50", "can.track_hz=10", "can.max_load_percent=100",
                   "can.frames=[{name=\"fast\", id=2000, size=0, period_ms=3.0}]"});
  INFO(late);
  CHECK(mentions(late, "frame fast (7D0) comes every"));
  const std::string twice = bus_error("ugv_hall", {"can.frames=[{name=\"gas\", id=288, period_ms=100}]"});
  CHECK(mentions(twice, "one identifier"));
  CHECK(bus_of("ugv_hall", {"can.frames=[{name=\"gas\", id=384, period_ms=100}]"}).streams.size() == 6);
}
