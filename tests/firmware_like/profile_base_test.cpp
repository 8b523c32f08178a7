// SPDX-License-Identifier: BSD-3-Clause
// Scenes that change another one: what is taken from where, what messages name, and what cannot be.
#include <catch2/catch.hpp>
#include <filesystem>

#include "firmware_like/scene/profile.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

const char* const kBelow = R"([scene]
name = "below"
vehicle = "cart"
about = "the whole story"

[groups.fast]
rate_hz = 100

[map]
voxel_m = 0.2
names = ["a", "b"]

[[rows]]
at_s = 1.0

[[rows]]
at_s = 2.0
)";

const char* const kAbove = R"([scene]
name = "above"
base = "below.toml"

[map]
names = ["c"]
range_m = 7.0

[groups.slow]
rate_hz = 10

[[rows]]
at_s = 5.0
)";

struct TwoScenes {
  TwoScenes() : below(folder.write("below.toml", kBelow)), above(folder.write("above.toml", kAbove)) {}
  TempFolder folder;
  std::string below;
  std::string above;
};

std::string base_refusal(const std::string& scene) {
  return message_of<ProfileError>([&] { static_cast<void>(load_scene(scene)); });
}

}  // namespace

TEST_CASE("a scene with a base takes what it does not say itself, and lists as a whole") {
  const TwoScenes files;
  Profile profile = load_scene(files.above, {"map.range_m=8"});
  CHECK(profile.name() == "above");
  CHECK(profile.base() == files.below);
  CHECK(profile.vehicle() == "cart");
  CHECK(profile.about() == "the whole story");
  CHECK(profile.number("map.voxel_m", {0.0, 0.0, 10.0}) == 0.2);
  CHECK(profile.number("map.range_m", {0.0, 0.0, 10.0}) == 8.0);
  CHECK(profile.texts("map.names", {}, "") == std::vector<std::string>{"c"});
  const auto rows =
      profile.rows("rows", {{"at_s", ColumnSpec::Kind::number, {0, 0, 9, "s", ""}, true}}, 8, "");
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].numbers.at("at_s") == 5.0);
  // Those of the base first, whatever their lines.
  CHECK(profile.tables("groups") == std::vector<std::string>{"fast", "slow"});
  // What a log carries stands for itself, and is that of one file that says it all.
  CHECK_FALSE(mentions(profile.canonical(), "base"));
  const Profile again(profile.canonical(), "log");
  CHECK(again.hash() == profile.hash());
  CHECK(again.base().empty());
  CHECK(load_scene(files.below).base().empty());
}

TEST_CASE("what is wrong in a base is told with the base's file and line") {
  const TwoScenes files;
  Profile profile = load_scene(files.above);
  const std::string base = message_of<ProfileError>([&] { profile.flag("map.voxel_m", true, ""); });
  INFO(base);
  CHECK(mentions(base, "below.toml:10: map.voxel_m"));
  const std::string own = message_of<ProfileError>([&] { profile.flag("map.range_m", true, ""); });
  INFO(own);
  CHECK(mentions(own, "above.toml:7: map.range_m"));
  const std::string unknown = message_of<ProfileError>([&] { profile.refuse_unknown_keys("groups"); });
  INFO(unknown);
  CHECK(mentions(unknown, "below.toml:7: unknown key groups.fast.rate_hz"));
}

TEST_CASE("a base may have a base and may be a scene of the program, but not itself or nothing") {
  const TwoScenes files;
  const std::string third =
      files.folder.write("third.toml", "[scene]\nname = \"third\"\nbase = \"above.toml\"\n");
  Profile profile = load_scene(third);
  CHECK(profile.base() == files.above);
  CHECK(profile.number("map.range_m", {0.0, 0.0, 10.0}) == 7.0);
  CHECK(profile.number("map.voxel_m", {0.0, 0.0, 10.0}) == 0.2);
  CHECK(load_scene(files.folder.write("hall.toml", "[scene]\nname = \"mine\"\nbase = \"ugv_hall\"\n"))
            .vehicle() == "ugv");

  const auto with_base = [&](const std::string& name, const std::string& base) {
    return base_refusal(files.folder.write(name, "[scene]\nname = \"x\"\nbase = " + base + "\n"));
  };
  CHECK(mentions(with_base("self.toml", "\"self.toml\""), "leads back to"));
  CHECK(mentions(with_base("dot.toml", "\"./dot.toml\""), "stand on each other"));
  CHECK(mentions(with_base("gone.toml", "\"nowhere.toml\""), "gone.toml: scene.base: "));
  CHECK(mentions(with_base("gone.toml", "\"ugv_hal\""), "unknown scene \"ugv_hal\"; known: "));
  CHECK(mentions(with_base("number.toml", "7"), "number.toml:3: scene.base: must be a scene's name"));
  // A log's profile reads no files.
  const Profile logged("[scene]\nname = \"x\"\nvehicle = \"cart\"\nbase = \"" + files.below + "\"\n", "log");
  CHECK_FALSE(logged.has("map.voxel_m"));
  CHECK(mentions(message_of<ProfileError>([&] { logged.refuse_unknown_keys(); }), "unknown key scene.base"));
}
