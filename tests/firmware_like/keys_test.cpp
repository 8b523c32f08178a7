// SPDX-License-Identifier: BSD-3-Clause
// One list of keys a config struct: what a profile may say, what a run may change, and how units are kept.
#include "rt/keys.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "firmware_like/runtime/live_keys.hpp"
#include "firmware_like/scene/units.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

enum class Colour : std::uint8_t { red = 3, green = 7 };

struct Lamp {
  double power_w{20};
  SORTIE_KEYS(c, key) { key("power_w", c.power_w, {0, 100, "W", "of the lamp"}); }
};

struct Rig {
  double gain{1.5};
  double arm_rad{90 * rt::kDegInRad.kept};
  double lag_s{0.0182};
  std::uint32_t count{4};
  std::int64_t offset{-2};
  rt::Nanoseconds wait_ns{rt::kNanosecondsPerSecond};
  rt::Nanoseconds block_ns{35 * rt::kNanosecondsPerMillisecond};
  std::uint32_t forget_ticks{250};
  bool on{true};
  bool learns{};
  Colour colour{Colour::green};
  rt::Vector3 place{1, 2, 3};
  bool has_lamp{true};
  Lamp lamp;
  double pool{8};
  double never_listed{5};

  SORTIE_KEYS(c, key) {
    key("gain", c.gain, {0.5, 2, "", "how much", rt::kKnob | rt::kLive});
    key("arm_deg", c.arm_rad, {-180, 180, rt::kDegInRad, "of the arm"},
        [widening = 2.0 * c.gain](auto& rig, double value) { return rig.turn(widening, value); });
    key("lag_ms", c.lag_s, {0.01, 500, rt::kMsInS, "of the motor"});
    key("count", c.count, {1, 9, "", "how many"});
    key("offset", c.offset, {-5, 5, "", "shift"});
    key("wait_s", c.wait_ns, {0, 3600, rt::kSInNs, "before the start"});
    key("block_ms", c.block_ns, {0.001, 1000, rt::kMsInNs, "between looks", rt::kLive});
    key("forget_s", c.forget_ticks, {0, 1e6, {"s", 1e3}, "then gone"});
    key("on", c.on, {"it is on"});
    key("steering", c.learns, {"how", {{"fixed", false}, {"learned", true}}, rt::kKnob});
    key("colour", c.colour, {"which", {{"green", Colour::green}, {"red", Colour::red}}});
    key("place_m", c.place, {-10, 10, "m", "where"});
    key("has_lamp", c.has_lamp, {"there is a lamp"});
    if (c.has_lamp) Lamp::keys(c.lamp, key);
    key("limits.pool", c.pool, {1, 64, "m", "in a table of its own"});
  }
};
static_assert(rt::Keyed<Rig> && rt::Keyed<const Rig> && !rt::Keyed<rt::Vector3>);

Profile profile_of(const std::string& keys) {
  return Profile("[scene]\nname = \"a\"\nvehicle = \"v\"\n\n" + keys, "rig.toml");
}

Rig read(const std::string& keys) {
  Profile profile = profile_of(keys);
  Rig rig;
  profile.read("rig", rig);
  profile.refuse_unknown_keys();
  return rig;
}

std::string error_of(const std::string& keys) {
  return message_of<ProfileError>([&] { static_cast<void>(read(keys)); });
}

const ProfileKey& key_of(const Profile& profile, const std::string& path) {
  for (const ProfileKey& key : profile.keys()) {
    if (key.path == path) return key;
  }
  FAIL("no key " << path);
  return profile.keys().front();
}

}  // namespace

TEST_CASE("every kind of key is read into its member, in the member's unit") {
  const Rig rig = read(
      "[rig]\ngain = 2\narm_deg = -45.5\nlag_ms = 18.3\ncount = 9\noffset = -5\nwait_s = 0.25\n"
      "block_ms = 8.2\nforget_s = 1.001\non = false\nsteering = \"learned\"\ncolour = \"red\"\n"
      "place_m = [4, 5.5, -6]\npower_w = 7\n\n[limits]\npool = 3\n");
  CHECK(rig.gain == 2.0);
  CHECK(rig.arm_rad == -45.5 * (3.14159265358979323846 / 180.0));
  CHECK(rig.lag_s == 1e-3 * 18.3);
  CHECK(rig.count == 9);
  CHECK(rig.offset == -5);
  CHECK(rig.wait_ns == 250'000'000);
  CHECK(rig.block_ns == 8'199'999);  // 8.2 * 1e6 is 8199999.999999999
  CHECK(rig.forget_ticks == 1000);   // so is 1.001 * 1000 less than 1001
  CHECK_FALSE(rig.on);
  CHECK(rig.learns);
  CHECK(rig.colour == Colour::red);
  CHECK((rig.place.x == 4.0 && rig.place.y == 5.5 && rig.place.z == -6.0));
  CHECK(rig.lamp.power_w == 7.0);
  CHECK(rig.pool == 3.0);
}

TEST_CASE("what a profile does not say stays as the struct has it, to the last bit, and is shown so") {
  Profile profile = profile_of("");
  Rig rig;
  rig.arm_rad = 35 * rt::kDegInRad.kept;  // a robot's own
  rig.colour = Colour::red;
  rig.never_listed = 6;
  const Rig before = rig;
  profile.read("rig", rig);
  CHECK(rig.arm_rad == before.arm_rad);
  CHECK(rig.colour == Colour::red);
  CHECK(rig.place.z == 3.0);
  CHECK(rig.never_listed == 6.0);
  std::string shown;
  for (const ProfileKey& key : profile.keys()) {
    if (key.path.rfind("scene.", 0) == 0) continue;
    CHECK(key.is_default);
    shown += key.path + "=" + key.value + " " + key.unit.name + " (" + key.range + ") " + key.meaning + "\n";
  }
  CHECK(shown ==
        "rig.gain=1.5  (0.5 .. 2) how much\n"
        "rig.arm_deg=35 deg (-180 .. 180) of the arm\n"
        "rig.lag_ms=18.2 ms (0.01 .. 500) of the motor\n"
        "rig.count=4  (1 .. 9) how many\n"
        "rig.offset=-2  (-5 .. 5) shift\n"
        "rig.wait_s=1 s (0 .. 3600) before the start\n"
        "rig.block_ms=35 ms (0.001 .. 1000) between looks\n"
        "rig.forget_s=0.25 s (0 .. 1000000) then gone\n"
        "rig.on=true  (true, false) it is on\n"
        "rig.steering=\"fixed\"  (fixed, learned) how\n"
        "rig.colour=\"red\"  (green, red) which\n"
        "rig.place_m=[1, 2, 3] m (-10 .. 10) where\n"
        "rig.has_lamp=true  (true, false) there is a lamp\n"
        "rig.power_w=20 W (0 .. 100) of the lamp\n"
        "limits.pool=8 m (1 .. 64) in a table of its own\n");
  CHECK(key_of(profile, "rig.arm_deg").number == 35.0);
  // Many numbers do not survive the way into another unit and back.
  std::uint32_t unlike = 0;
  for (int k = 1; k <= 500; ++k) {
    Rig awkward;
    awkward.arm_rad = 0.1 * std::sqrt(k);
    Profile says_nothing = profile_of("");
    says_nothing.read("rig", awkward);
    unlike += awkward.arm_rad != 0.1 * std::sqrt(k) ? 1 : 0;
  }
  CHECK(unlike == 0);
}

TEST_CASE("a listed key that cannot be used is refused with line, range and unit") {
  CHECK(error_of("[rig]\ngain = 1\n").empty());
  CHECK(error_of("[rig]\n\ngain = 2.5\n") == "rig.toml:7: rig.gain: 2.5 is outside 0.5 .. 2");
  CHECK(error_of("[rig]\narm_deg = 181\n") == "rig.toml:6: rig.arm_deg: 181 is outside -180 .. 180 deg");
  CHECK(error_of("[rig]\nwait_s = -1\n") == "rig.toml:6: rig.wait_s: -1 is outside 0 .. 3600 s");
  for (const char* wild : {"nan", "-nan", "inf", "-inf"}) {
    for (const char* name : {"gain", "arm_deg", "lag_ms", "wait_s", "block_ms", "forget_s"}) {
      INFO(name << " = " << wild);
      CHECK(mentions(error_of(std::string("[rig]\n") + name + " = " + wild + "\n"), "is outside"));
    }
  }
  CHECK(mentions(error_of("[rig]\ncount = nan\n"), "rig.toml:6: rig.count: must be a whole number"));
  CHECK(mentions(error_of("[rig]\ncount = 4.0\n"), "must be a whole number"));
  CHECK(mentions(error_of("[rig]\ncount = 10\n"), "rig.count: 10 is outside 1 .. 9"));
  CHECK(mentions(error_of("[rig]\non = 1\n"), "rig.on: must be true or false"));
  CHECK(mentions(error_of("[rig]\nblock_ms = \"8\"\n"), "rig.block_ms: must be a number in ms"));
  CHECK(mentions(error_of("[rig]\nsteering = true\n"), "rig.steering: must be a text in quotes"));
  CHECK(mentions(error_of("[rig]\ncolour = \"blue\"\n"), "\"blue\" is not one of: green, red"));
  CHECK(mentions(error_of("[rig]\nplace_m = [1, 2]\n"), "must be a list of 3 numbers"));
  CHECK(mentions(error_of("[rig]\nplace_m = [1, 2, 11]\n"), "number 3 is outside -10 .. 10 m"));
  CHECK(mentions(error_of("[limits]\npool = 65\n"), "rig.toml:6: limits.pool: 65 is outside 1 .. 64 m"));
}

TEST_CASE("what no list has is an unknown key, with its line and the nearest that is listed") {
  const std::string typo = error_of("[rig]\ncount = 2\nblok_ms = 3\n");
  CHECK(mentions(typo, "rig.toml:7: unknown key rig.blok_ms; did you mean rig.block_ms?"));
  // The list ends where the part is not there.
  CHECK(error_of("[rig]\nhas_lamp = true\npower_w = 3\n").empty());
  CHECK(mentions(error_of("[rig]\nhas_lamp = false\npower_w = 3\n"), "unknown key rig.power_w"));
  // A name with a dot is not in the table.
  CHECK(mentions(error_of("[rig]\npool = 3\n"), "unknown key rig.pool"));
}

TEST_CASE("a default beyond its range is refused, as what a profile says is") {
  Profile profile = profile_of("");
  Rig rig;
  rig.gain = std::nan("");
  CHECK(mentions(message_of<ProfileError>([&] { profile.read("rig", rig); }), "rig.gain: nan is outside"));
}

TEST_CASE("units are kept as they always were, and what a struct holds is written so that it comes back") {
  const rt::KeySpec ms{0, 1e6, rt::kMsInNs, ""};
  const rt::KeySpec us{0, 1e6, rt::kUsInNs, ""};
  const rt::KeySpec s{0, 1e6, rt::kSInNs, ""};
  const rt::KeySpec deg{-360, 360, rt::kDegInRad, ""};
  const rt::KeySpec lag{0, 1000, rt::kMsInS, ""};
  std::uint32_t lost = 0;
  std::uint32_t cut = 0;
  for (std::int64_t k = 0; k <= 1'000'000; ++k) {
    const double written = static_cast<double>(k) / 1000.0;  // as a decimal is read
    const auto in_ms = rt::from_written<rt::Nanoseconds>(written, ms);
    const auto in_s = rt::from_written<rt::Nanoseconds>(written, s);
    lost += in_ms != milliseconds(written) ? 1 : 0;
    lost += in_s != milliseconds(1e3 * written) ? 1 : 0;
    cut += in_ms != k * 1000 ? 1 : 0;
    lost += k * 1000 - in_ms > 1 ? 1 : 0;
    lost +=
        rt::from_written<rt::Nanoseconds>(written, us) != static_cast<rt::Nanoseconds>(written * 1e3) ? 1 : 0;
    lost += rt::as_written<rt::Nanoseconds>(k * 1000, ms) != written ? 1 : 0;
    lost += rt::as_written<rt::Nanoseconds>(k * 1'000'000, s) != written ? 1 : 0;
    lost += rt::as_written(rt::from_written<double>(written, deg), deg) != written ? 1 : 0;
    lost += rt::as_written(rt::from_written<double>(-written, deg), deg) != -written ? 1 : 0;
    lost += rt::as_written(rt::from_written<double>(written, lag), lag) != written ? 1 : 0;
  }
  CHECK(lost == 0);
  CHECK(cut > 0);  // else the first comparison would see no difference between cutting and rounding
  CHECK(rt::from_written<rt::Nanoseconds>(8.2, ms) == 8'199'999);
  CHECK(rt::from_written<rt::Nanoseconds>(-0.3, ms) == milliseconds(-0.3));
}

TEST_CASE("a key is a knob where its list says so, or where somebody else does") {
  Profile profile = profile_of("");
  profile.knob("rig.on");
  Rig rig;
  profile.read("rig", rig);
  profile.knob("rig.count");
  std::set<std::string> knobs;
  for (const ProfileKey& key : profile.keys()) {
    if (key.is_knob) knobs.insert(key.path);
  }
  CHECK(knobs == std::set<std::string>{"rig.gain", "rig.steering", "rig.on", "rig.count"});
}

namespace {

// Takes a setter's number, in the member's unit.
struct RigOwner {
  double widened_rad{};
  Status turn(double widening, double rad) {
    if (rad < 0) return Status::out_of_range;
    widened_rad = widening * rad;
    return Status::ok;
  }
};

struct RigVehicle final : Vehicle {
  explicit RigVehicle(VehicleBuilder& builder) {
    const rt::GroupId group = builder.group("g", 100);
    builder.profile().read("rig", rig);
    live_keys(builder, group, "rig", owner, rig);
    live_keys(builder, group, "rig", rig);
    builder.task<rt::PoseEstimate>(group, "t", 1, [](rt::JobContext&, rt::PoseEstimate&) {});
  }
  Rig rig;
  RigOwner owner;
};

}  // namespace

TEST_CASE("a live key is a run-time parameter in its list's range: set by its setter, or written") {
  RigVehicle* built = nullptr;
  const VehicleRegistry vehicles{{"v", [&built](VehicleBuilder& builder) {
                                    auto vehicle = std::make_unique<RigVehicle>(builder);
                                    built = vehicle.get();
                                    return vehicle;
                                  }}};
  Runtime runtime(profile_of("[rig]\ngain = 2\narm_deg = 30\n"), vehicles, RuntimeStart{});
  const ParameterSet& set = runtime.parts().parameters();
  std::string known;
  for (const ParameterInfo& info : set.all) known += std::string(info.key().name) + " ";
  CHECK(known == "rig.arm_deg rig.gain rig.block_ms ");
  CHECK(set.find("rig.arm_deg")->owner->table.state().value[0] == 30.0);
  CHECK(set.find("rig.arm_deg")->key().high == 180.0);
  CHECK(std::string(set.find("rig.arm_deg")->key().unit.name) == "deg");
  const auto change = [&](const char* name, double value) {
    rt::ParameterChange asked;
    REQUIRE(rt::make_change(name, value, 1, asked) == Status::ok);
    return set.find(name)->owner->table.apply(asked);
  };
  CHECK(change("rig.arm_deg", 60) == Status::ok);
  CHECK(built->owner.widened_rad == 4.0 * (60 * rt::kDegInRad.kept));  // the gain that was read
  CHECK(change("rig.arm_deg", -60) == Status::out_of_range);           // refused by the setter
  CHECK(change("rig.arm_deg", 181) == Status::out_of_range);
  CHECK(change("rig.block_ms", 8.2) == Status::ok);
  CHECK(built->rig.block_ns == 8'199'999);
  CHECK(change("rig.gain", 0.4) == Status::out_of_range);
  CHECK(built->rig.gain == 2.0);
  std::set<std::string> changeable;
  for (const ProfileKey& key : runtime.profile().keys()) {
    if (key.is_changeable) changeable.insert(key.path);
  }
  CHECK(changeable == std::set<std::string>{"rig.arm_deg", "rig.block_ms", "rig.gain"});
}
