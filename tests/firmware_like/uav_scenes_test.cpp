// SPDX-License-Identifier: BSD-3-Clause
// The multirotor's scenes in closed loop: where it ends, what it touches, what it does without fixes and
// without a way; replay and keyframes.
#include <catch2/catch.hpp>
#include <cmath>

#include "planner/uav_pilot.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

struct Flown {
  Flown(const std::string& scene, double seconds, std::vector<std::string> overrides = {},
        const std::string& record = "") {
    LiveRunOptions options;
    options.scene = scene;
    options.overrides = std::move(overrides);
    options.seconds = seconds;
    options.virtual_time = true;
    options.record = record;
    options.record_fields = !record.empty();
    options.lcm_url = "none";
    run = run_live(own_vehicles(), make_simulated_robot, options);
  }
  std::uint64_t counter(const std::string& name) const { return run.results.counters.at(name); }
  /// Horizontal distance of the true end from a place.
  double ends_off_m(double x_m, double y_m) const {
    const auto& p = run.truth.back().p;
    return std::hypot(p[0] - x_m, p[1] - y_m);
  }
  LiveRunOutcome run;
};

const std::vector<std::string> kOneGoal = {"mission.goals=[{x_m=13.5,y_m=0.0,z_m=1.5,wait_s=0.5}]"};

}  // namespace

TEST_CASE("A hexacopter takes off, hovers and lands softly, for each of the vehicles' files") {
  for (const char* scene : {"uav_neo11", "uav_neo9", "uav_firefly"}) {
    INFO(scene);
    const Flown flown(scene, 16);
    CHECK(flown.counter("goals_reached") == 2);
    CHECK(flown.counter("bench_landed") == 1);
    CHECK(flown.counter("bench_touch_down_mm_s") < 1000);
    CHECK(flown.counter("flight_rotors_lost") == 0);
    CHECK(flown.ends_off_m(1, 0) < 0.05);
    CHECK(flown.counter("bench_rotors_stale_ms") == 0);
  }
}

TEST_CASE(
    "The corridor is flown to its goal within 5 cm and nothing is touched, and the log replays to its "
    "digest") {
  const TempFolder folder;
  const std::string log = folder.file("corridor.lcm");
  const Flown flown("uav_corridor", 22, kOneGoal, log);
  CHECK(flown.counter("goals_reached") == 1);
  CHECK(flown.counter("bench_collisions") == 0);
  CHECK(flown.counter("bench_least_gap_mm") > 50);
  CHECK(flown.ends_off_m(13.5, 0) < 0.05);
  CHECK(flown.run.results.counters.at("goals_without_way") == 0);
  const ReplayOutcome outcome = replay_log(log);
  if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
  CHECK(outcome.results.digest == flown.run.results.digest);
  ReplayOptions threaded;
  threaded.threaded = true;
  CHECK(replay_log(log, threaded).results.digest == flown.run.results.digest);
}

TEST_CASE("Without fixes for half a second it hovers, goes on, and still touches nothing") {
  auto dark = kOneGoal;
  dark.insert(dark.end(), {"hil.dark_from_s=6.0", "hil.dark_to_s=6.5"});
  const Flown flown("uav_corridor", 25, dark);
  CHECK(flown.counter("times_without_fixes") >= 1);
  CHECK(flown.counter("goals_reached") == 1);
  CHECK(flown.counter("bench_collisions") == 0);
  CHECK(flown.ends_off_m(13.5, 0) < 0.05);
}

TEST_CASE("A position that is lost for good ends in a level landing") {
  const Flown flown("uav_neo11", 20, {"hil.dark_from_s=5.0", "hil.dark_to_s=100"});
  CHECK(flown.counter("bench_landed") == 1);
  CHECK(flown.counter("bench_touch_down_mm_s") < 1500);
}

TEST_CASE("A door that is shut under way is noticed, and the other one is taken") {
  const Flown flown("uav_hall", 45);
  CHECK(flown.counter("ways_given_up") >= 1);
  CHECK(flown.counter("goals_reached") == 2);
  CHECK(flown.counter("bench_collisions") == 0);
  CHECK(flown.ends_off_m(0, 2) < 0.05);
}

TEST_CASE("Where there is no way it hovers and asks again, and does not fly through the wall") {
  const Flown flown("uav_neo11", 8,
                    {"tasks.path.enabled=true", "mission.goals=[{x_m=10.0,y_m=0.0,z_m=1.5}]",
                     "world.boxes=[{x_m=4.0,y_m=-4.0,length_m=0.2,width_m=8.0,height_m=4.0}]"});
  CHECK(flown.counter("goals_without_way") >= 2);
  CHECK(flown.counter("goals_reached") == 0);
  CHECK(flown.counter("bench_collisions") == 0);
  CHECK(flown.ends_off_m(0, 0) < 0.1);
}

TEST_CASE("A flight that is replayed from any keyframe, also in the middle of a search, ends in its digest") {
  const TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  // So few units a job that a search takes several of them; the door is shut while it flies.
  const Flown flown("uav_hall", 9,
                    {"tasks.path.units=640", "mission.start_s=0.5",
                     "world.boxes=[{x_m=4.0,y_m=-2.0,length_m=0.2,width_m=6.0},"
                     "{x_m=4.0,y_m=-4.0,length_m=0.2,width_m=2.0,from_s=4.25}]"},
                    log);
  CHECK(flown.counter("ways_given_up") == 1);
  const Indexed indexed = replay_and_keep(log, own_vehicles(), {}, 250, keyframe_path(log));
  CHECK(indexed.outcome.results.digest == flown.run.results.digest);
  for (const char* from : {"1.75", "2.25", "2.5", "4.5", "8.0"}) {
    INFO(from);
    ReplayOptions options;
    options.from = from;
    const ReplayOutcome part = replay_log(log, options);
    if (part.divergence) FAIL_CHECK(describe(*part.divergence));
    CHECK(part.results.digest == flown.run.results.digest);
  }
}

TEST_CASE("A vehicle's file that cannot fly is refused with its line") {
  const auto problem = [](const std::string& override_) {
    try {
      const Runtime runtime(load_scene("uav_corridor", {override_}), own_vehicles(), RuntimeStart{});
    } catch (const ProfileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(problem("airframe.mass_kg=40"), Catch::Contains("cannot lift"));
  CHECK_THAT(problem("airframe.mass_kg=0"), Catch::Contains("mass_kg"));
  CHECK_THAT(problem("limits.path_voxels=1000"), Catch::Contains("power of two"));
  CHECK_THAT(problem("airframe.radius_m=3"), Catch::Contains("too large"));
  CHECK_THAT(problem("state.lost_after_s=0.1"), Catch::Contains("dead_after_s"));
}
