// SPDX-License-Identifier: BSD-3-Clause
// What the gate takes, against a list of everything it took.
#include "planner/request_gate.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

using namespace sortie;
using namespace sortie::planner;

namespace {

constexpr rt::Nanoseconds kOld = 1000;

// Says the same from the whole history: slow, and in other words than the gate.
struct Historian {
  struct Entry {
    std::int64_t counter;
    std::uint32_t rank;
  };
  std::vector<Entry> taken{{0, 0}};
  std::int64_t highest() const {
    std::int64_t most = 0;
    for (const Entry& entry : taken) {
      if (entry.counter - most <= kMostCounterStep) most = std::max(most, entry.counter);
    }
    return most;
  }
  // `rank`: of the request, 0 to 3; `sound`: of its content; `age`: when it is to be taken.
  bool takes(std::int64_t counter, std::uint32_t rank, bool sound, rt::Nanoseconds age, bool any_order) {
    const bool next = counter > highest() && counter <= highest() + kMostCounterStep;
    const bool stop_out_of_turn = rank > 0 && any_order && rank >= taken.back().rank;
    const bool good = rank > 0 || (sound && age <= kOld);
    const bool is_taken = good && (next || stop_out_of_turn);
    if (is_taken) taken.push_back({counter, rank});
    return is_taken;
  }
};

}  // namespace

TEST_CASE("The gate takes what its history allows, of drives and of pilots") {
  const unsigned seed = 424;
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  int stops_out_of_turn = 0;
  for (int life = 0; life < 200; ++life) {
    RequestGate drive;
    RequestGate pilot;
    Historian of_drive;
    Historian of_pilot;
    for (int i = 0; i < 200; ++i) {
      const auto step = static_cast<std::int64_t>(random() % 7) - 3;
      const std::int64_t far = random() % 20 == 0 ? static_cast<std::int64_t>(random() % 2'000'000) : 0;
      const auto mode = static_cast<std::uint32_t>(random() % 6);
      const bool sound = random() % 8 != 0;
      const rt::Nanoseconds age = random() % 8 == 0 ? kOld + 1 : kOld;
      const bool any = random() % 2 == 0;
      const StopOrder order = any ? StopOrder::any : StopOrder::rising;
      const RequestRules rules{1, kOld};

      rt::DriveRequest ground;
      ground.counter = of_drive.highest() + step + far;
      ground.mode = mode;  // 5 is none
      ground.posture = sound ? 0 : 1;
      const std::uint32_t halts = mode == 2 ? 1 : mode == 3 ? 2 : 0;
      const std::int64_t before = drive.newest;
      REQUIRE((drive.take(ground, rules, age, order) == Status::ok) ==
              of_drive.takes(ground.counter, halts, sound && mode != 5, age, any));
      REQUIRE(drive.newest == of_drive.highest());
      stops_out_of_turn += halts != 0 && any && ground.counter <= before ? 1 : 0;

      rt::FlyRequest air;
      air.counter = of_pilot.highest() + step + far;
      air.mode = mode;  // 5 is none
      air.p_world_m[1] = sound ? 1.0 : 1e5;
      const std::uint32_t rank = mode >= 1 && mode <= 3 ? mode : 0;
      REQUIRE((pilot.take(air, rules, age, order) == Status::ok) ==
              of_pilot.takes(air.counter, rank, sound && mode != 5, age, any));
      REQUIRE(pilot.newest == of_pilot.highest());
    }
  }
  CHECK(stops_out_of_turn > 1000);
}

TEST_CASE("No counter makes the gate count beyond its numbers") {
  RequestGate gate;
  rt::DriveRequest request;
  request.counter = std::numeric_limits<std::int64_t>::max();
  CHECK(gate.take(request, {}, 0) == Status::malformed);
  request.counter = std::numeric_limits<std::int64_t>::min();
  CHECK(gate.take(request, {}, 0) == Status::time_repeated);
  gate.newest = std::numeric_limits<std::int64_t>::min();  // of a damaged keyframe
  request.counter = std::numeric_limits<std::int64_t>::max();
  CHECK(gate.take(request, {}, 0) == Status::malformed);
  request.mode = static_cast<std::uint32_t>(rt::DriveMode::halt);
  CHECK(gate.take(request, {}, 0) == Status::ok);
}
