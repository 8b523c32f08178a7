// SPDX-License-Identifier: BSD-3-Clause
// Flight controller and map restored from bytes go on as those that were saved, and broken bytes are refused.
// Plans: tests/planner/uav_guide_test.cpp.
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "planner/uav_control/uav_control.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {
namespace {

template <class Object>
std::vector<std::uint8_t> saved_bytes(Object& object) {
  rt::Archive measure = rt::Archive::measuring();
  object.archive(measure);
  INFO(measure.where() << ": " << measure.why());
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  object.archive(out);
  REQUIRE(out.status() == Status::ok);
  CHECK(out.bytes() == bytes.size());
  return bytes;
}

template <class Object>
Status restored_from(Object& object, const std::vector<std::uint8_t>& bytes) {
  rt::Archive in = rt::Archive::reading(bytes);
  object.archive(in);
  if (in.status() == Status::ok) CHECK(in.bytes() == bytes.size());
  return in.status();
}

UavControlConfig archived_vehicle() {
  UavControlConfig config;
  config.model.mass_kg = 1.6;
  config.model.inertia_kg_m2 = {0.035, 0.046, 0.098};
  config.model.thrust_n_s2 = 8.5e-6;
  config.model.moment_m = 0.016;
  config.model.tau_up_s = 0.0125;
  config.model.tau_down_s = 0.025;
  config.model.max_speed_rad_s = 838;
  place_rotors(config.model, 6, 0.215, 0.52);
  return config;
}

// A state that no vehicle has, near a hover: the controller must only answer, not fly.
rt::UavState any_state(std::mt19937& random, rt::Nanoseconds stamp_ns) {
  const auto draw = [&random](double size) {
    return size * (static_cast<double>(random()) / 2147483648.0 - 1.0);
  };
  rt::UavState state;
  state.stamp_ns = stamp_ns;
  state.verdict = rt::UavVerdict::good;
  for (double& value : state.p_world_m) value = draw(0.2);
  for (double& value : state.v_world_m_s) value = draw(0.5);
  for (double& value : state.w_body_rad_s) value = draw(0.3);
  const double x = draw(0.2);
  const double y = draw(0.2);
  const double z = draw(0.2);
  rt::store(rt::exp_rotation({x, y, z}), state.q_world_body);
  return state;
}

}  // namespace

TEST_CASE("A flight controller restored from bytes commands what the saved one does, bit for bit") {
  const std::uint32_t seed = 11;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const UavControlConfig config = archived_vehicle();
  auto control = std::make_unique<UavControl>(config);
  REQUIRE(control->start(any_state(random, 1)) == Status::ok);
  rt::Nanoseconds now = 1;
  rt::RotorCommand command;
  for (int round = 0; round < 12; ++round) {
    if (round % 4 == 0) CHECK(control->set_goal({0.4, 0.1 * round, 0.2}, 0.3 * round) == Status::ok);
    if (round == 6) control->land();
    for (int k = 0; k < 17 + round; ++k)
      static_cast<void>(control->update(any_state(random, now += 10'000'000), command));
    const std::vector<std::uint8_t> bytes = saved_bytes(*control);
    auto copy = std::make_unique<UavControl>(config);
    REQUIRE(restored_from(*copy, bytes) == Status::ok);
    CHECK(saved_bytes(*copy) == bytes);
    for (int k = 0; k < 25; ++k) {
      const rt::UavState state = any_state(random, now += 10'000'000);
      rt::RotorCommand other;
      CHECK(control->update(state, command) == copy->update(state, other));
      for (std::uint32_t i = 0; i < rt::kMaxRotors; ++i)
        CHECK(command.speed_rad_s[i] == other.speed_rad_s[i]);
    }
    CHECK(saved_bytes(*copy) == saved_bytes(*control));
  }
}

TEST_CASE("A map restored from bytes is the one that was saved") {
  OwnedMap owned(cube(60, 48, 16, 0.3, 0.2));
  build_hall(owned.map, 5, 2, 12);
  OwnedMap other(cube(60, 48, 16, 0.3, 0.2));
  REQUIRE(restored_from(other.map, saved_bytes(owned.map)) == Status::ok);
  CHECK(other.free == owned.free);
  CHECK(other.map.version() == owned.map.version());
}

TEST_CASE("Broken bytes of a controller are refused or lead to some command, never out of its tables") {
  const std::uint32_t seed = 23;
  CAPTURE(seed);
  std::mt19937 random(seed);
  auto control = std::make_unique<UavControl>(archived_vehicle());
  REQUIRE(control->start(any_state(random, 1)) == Status::ok);
  const std::vector<std::uint8_t> good = saved_bytes(*control);
  for (int n = 0; n < 200; ++n) {
    std::vector<std::uint8_t> bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    static_cast<void>(restored_from(*control, bytes));
    rt::RotorCommand command;
    static_cast<void>(control->update(any_state(random, (n + 1) * 10'000'000), command));
    CHECK(command.rotors <= rt::kMaxRotors);
  }
  CHECK(restored_from(*control, {good.begin(), good.end() - 1}) == Status::malformed);
}

}  // namespace sortie::planner::test
