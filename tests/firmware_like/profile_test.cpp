// SPDX-License-Identifier: BSD-3-Clause
// Profiles: what is wrong is said in one line with file, line, fault and cure; what is right is stable text.
#include "firmware_like/scene/profile.hpp"

#include <catch2/catch.hpp>

#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

const std::string kSmallProfile = R"([scene]
name = "small"
vehicle = "ugv"

[map]
voxel_m = 0.1
count = 7
on = true
route = [[1.0, 2.0], [3, -4.5]]
)";

Profile small(const std::vector<std::string>& overrides = {}) {
  return Profile(kSmallProfile, "small.toml", overrides);
}

std::string error_of(const std::function<void()>& call) { return message_of<ProfileError>(call); }

// Loading a scene and building it, as every command does.
std::string scene_error(const std::vector<std::string>& overrides) {
  return error_of(
      [&] { const Runtime runtime(load_scene("ugv_hall", overrides), own_vehicles(), RuntimeStart{}); });
}

}  // namespace

TEST_CASE("an unknown key is named with its line and the nearest key that is known") {
  Profile typo("[scene]\nname=\"a\"\nvehicle=\"ugv\"\n[map]\nvoxl_m = 0.3\n", "typo.toml");
  static_cast<void>(typo.number("map.voxel_m", {0.2, 0.01, 1, "m", ""}));
  const std::string near = error_of([&] { typo.refuse_unknown_keys(); });
  INFO(near);
  CHECK(mentions(near, "typo.toml:5: unknown key map.voxl_m"));
  CHECK(mentions(near, "did you mean map.voxel_m?"));

  Profile far("[scene]\nname=\"a\"\nvehicle=\"ugv\"\n\n\n[zebra]\nstripes = 3\n", "far.toml");
  const std::string nothing_near = error_of([&] { far.refuse_unknown_keys(); });
  INFO(nothing_near);
  CHECK(mentions(nothing_near, "far.toml:7: unknown key zebra.stripes"));
  CHECK_FALSE(mentions(nothing_near, "did you mean"));
  CHECK(error_of([&] { far.refuse_unknown_keys("", "zebra"); }).empty());
  CHECK(error_of([&] { far.refuse_unknown_keys("hil"); }).empty());
}

TEST_CASE("a whole number that no double can hold is refused, not rounded and not left at its default") {
  const NumberSpec any{7, -1e19, 1e19, "", ""};
  for (const char* last : {"9007199254740992", "-9007199254740992"}) {
    Profile profile("[scene]\nname=\"a\"\nvehicle=\"ugv\"\n[map]\ncount = " + std::string(last) + "\n",
                    "far.toml");
    CHECK(profile.number("map.count", any) == std::stod(last));
  }
  for (const char* odd :
       {"9007199254740993", "9007199254740994", "-9007199254740993", "9223372036854775807"}) {
    Profile profile("[scene]\nname=\"a\"\nvehicle=\"ugv\"\n[map]\ncount = " + std::string(odd) +
                        "\n[[script]]\nat_s = 1\nset = \"map.count\"\nvalue = " + odd + "\n",
                    "far.toml");
    CHECK(mentions(error_of([&] { static_cast<void>(profile.number("map.count", any)); }), "2^53"));
    CHECK(mentions(error_of([&] { static_cast<void>(profile.integer("map.count", any)); }), "2^53"));
    CHECK(mentions(error_of([&] { static_cast<void>(profile.integer_or_auto("map.count", any)); }), "2^53"));
    CHECK(mentions(error_of([&] { static_cast<void>(profile.script()); }), "2^53"));
  }
}

TEST_CASE("a scene of the program refuses unknown keys, wherever they stand") {
  CHECK(scene_error({}).empty());
  CHECK(mentions(scene_error({"map.voxel=0.2"}), "unknown key map.voxel; did you mean map.voxel_m?"));
  CHECK(mentions(scene_error({"maps.voxel_m=0.2"}), "did you mean map.voxel_m?"));
  CHECK(mentions(scene_error({"groups.contrl.rate_hz=100"}), "did you mean groups.control.rate_hz?"));
}

TEST_CASE("a value of another type or out of range is named with line, range and unit") {
  Profile profile = small();
  CHECK(mentions(error_of([&] {
                   static_cast<void>(profile.number("map.on", {0, 0, 1, "m", ""}));
                 }),
                 "small.toml:8: map.on: must be a number in m"));
  CHECK(mentions(error_of([&] {
                   static_cast<void>(profile.integer("map.voxel_m", {0, 0, 9, "", ""}));
                 }),
                 "small.toml:6: map.voxel_m: must be a whole number"));
  CHECK(mentions(error_of([&] { static_cast<void>(profile.flag("map.count", false, "")); }),
                 "small.toml:7: map.count: must be true or false"));
  CHECK(mentions(error_of([&] { static_cast<void>(profile.text("map.count", "", "")); }), "text in quotes"));
  CHECK(mentions(error_of([&] {
                   static_cast<void>(profile.number("map.voxel_m", {0.2, 0.5, 1, "m", ""}));
                 }),
                 "small.toml:6: map.voxel_m: 0.1 is outside 0.5 .. 1 m"));
  CHECK(mentions(error_of([&] {
                   static_cast<void>(profile.text("scene.name", "", "", {"tall", "wide"}));
                 }),
                 "\"small\" is not one of: tall, wide"));
  for (const char* value : {"nan", "inf", "-inf"}) {
    INFO(value);
    Profile wild = small({std::string("map.voxel_m=") + value});
    CHECK(mentions(error_of([&] {
                     static_cast<void>(wild.number("map.voxel_m", {0.2, 0, 1, "m", ""}));
                   }),
                   "is outside"));
  }
  CHECK(mentions(error_of([] { Profile("[scene\n", "broken.toml"); }), "broken.toml:1: not valid TOML"));
  CHECK(mentions(error_of([] { Profile("[scene]\nvehicle=\"ugv\"\n", "anon.toml"); }), "name"));
  CHECK(mentions(error_of([] { Profile("[scene]\nname=\"x\"\n", "anon.toml"); }), "vehicle"));
}

TEST_CASE(
    "an override (--set) changes a key, makes a missing table, and is refused where it cannot be meant") {
  Profile profile = small({"map.voxel_m=0.25", "new.table.key=3", "scene.about=bare words stand for text"});
  CHECK(profile.number("map.voxel_m", {0.2, 0, 1, "m", ""}) == 0.25);
  CHECK(profile.integer("new.table.key", {0, 0, 9, "", ""}) == 3);
  CHECK(profile.about() == "bare words stand for text");
  CHECK(mentions(error_of([] { small({"map.voxel_m"}); }), "write key=value"));
  CHECK(mentions(error_of([] { small({"=3"}); }), "write key=value"));
  CHECK(mentions(error_of([] { small({"map.voxel_m.deep=3"}); }), "map.voxel_m is not a table"));
  // A mistyped value is a text, and then of the wrong type.
  CHECK(mentions(error_of([] {
                   Profile wrong = small({"map.voxel_m=O.2"});
                   static_cast<void>(wrong.number("map.voxel_m", {0.2, 0, 1, "m", ""}));
                 }),
                 "must be a number"));
}

TEST_CASE("a rate that is no whole number of ticks is refused with the nearest rates that are") {
  const std::string why = scene_error({"groups.control.rate_hz=300"});
  INFO(why);
  CHECK(mentions(why, "300 Hz is no whole number of base ticks (1000 us)"));
  CHECK(mentions(why, "nearest legal: 333.333 and 250 Hz"));
  // Faster than the base tick: there is only one neighbour.
  const std::string fast = scene_error({"groups.control.rate_hz=1500"});
  INFO(fast);
  CHECK(mentions(fast, "nearest legal: 1000 Hz"));
  CHECK(scene_error({"groups.control.rate_hz=250"}).empty());
  CHECK(scene_error({"groups.control.rate_hz=2000", "time.base_tick_us=500"}).empty());
  CHECK(mentions(scene_error({"groups.mapping.deadline_ticks=101"}), "is outside"));
  CHECK(mentions(scene_error({"groups.mapping.deadline_ticks=2.5"}), "whole number"));
}

TEST_CASE("lists of points are read whole or refused") {
  Profile profile = small();
  const auto route = profile.points("map.route", 8, "");
  REQUIRE(route.size() == 2);
  CHECK(route[0] == std::array<double, 2>{1, 2});
  CHECK(route[1] == std::array<double, 2>{3, -4.5});
  CHECK(profile.points("map.absent", 8, "").empty());
  CHECK(mentions(error_of([&] { static_cast<void>(profile.points("map.route", 1, "")); }), "at most 1"));
  for (const char* bad : {"map.route=[[1.0]]", "map.route=[[1.0, 2.0, 3.0]]", "map.route=[1.0, 2.0]",
                          "map.route=7", "map.route=[[1.0, \"x\"]]", "map.route=[[nan, 1.0]]"}) {
    INFO(bad);
    Profile wrong = small({bad});
    CHECK_FALSE(error_of([&] { static_cast<void>(wrong.points("map.route", 8, "")); }).empty());
  }
}

TEST_CASE("the canonical text is stable: parsed again it gives itself, and order does not matter") {
  const Profile profile = small({"map.voxel_m=0.30000000000000004", "map.count=-3"});
  const Profile again(profile.canonical(), "again");
  CHECK(again.canonical() == profile.canonical());
  CHECK(again.hash() == profile.hash());
  CHECK(small({"a.b=1", "c=2"}).hash() == small({"c=2", "a.b=1"}).hash());
  CHECK(small().hash() != small({"map.count=8"}).hash());
  // One bit of one number is another profile.
  CHECK(small({"map.voxel_m=0.30000000000000004"}).hash() != small({"map.voxel_m=0.3"}).hash());
  for (const BuiltInScene& scene : built_in_scenes()) {
    INFO(scene.name);
    const Profile loaded = load_scene(scene.name);
    CHECK(loaded.name() == scene.name);
    CHECK(Profile(loaded.canonical(), "again").hash() == loaded.hash());
  }
}

TEST_CASE("a scene is found by name or file, and an unknown one lists those that exist") {
  const std::string unknown = error_of([] { static_cast<void>(load_scene("ugv_hal")); });
  INFO(unknown);
  CHECK(mentions(unknown, "unknown scene \"ugv_hal\""));
  CHECK(mentions(unknown, "ugv_hall"));
  CHECK(mentions(error_of([] { static_cast<void>(load_scene("/nowhere/x.toml")); }), "/nowhere/x.toml"));
  const TempFolder folder;
  CHECK(load_scene(folder.write("mine.toml", kSmallProfile)).name() == "small");
}
