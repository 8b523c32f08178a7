// SPDX-License-Identifier: BSD-3-Clause
// Run-time parameters of a vehicle: scripts, the desk where changes are asked for, and logs with changes.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "firmware_like/link/request_door.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LiveRunOptions hall_options(const std::vector<std::string>& more = {}) {
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768",
                       "mission.start_s=0.5"};
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.seconds = 3;
  options.virtual_time = true;
  options.lcm_url = "none";
  return options;
}

std::string row(double at_s, const std::string& name, double value) {
  std::ostringstream text;
  text << "{at_s=" << std::fixed << at_s << ",set=\"" << name << "\",value=" << value << "}";
  return text.str();
}

std::string problem_of(const std::string& script) {
  return message_of<ProfileError>([&] {
    static_cast<void>(Runtime(load_scene("ugv_hall", {"script=" + script}), own_vehicles(), RuntimeStart{}));
  });
}

}  // namespace

TEST_CASE("a scripted change is in force from its tick on and stands in the digest") {
  const TempFolder folder;
  const std::string log_path = folder.file("set.lcm");
  LiveRunOptions options = hall_options({"script=[" + row(2.0, "drive.max_speed_m_s", 0.2) + "]"});
  options.record = log_path;
  options.record_fields = true;
  const bool counts_heap = watch_heap();
  const LiveRunOutcome changed = run_live(own_vehicles(), make_simulated_robot, options);
  const LiveRunOutcome plain = run_live(own_vehicles(), make_simulated_robot, hall_options());
  CHECK(changed.results.digest != plain.results.digest);
  CHECK(changed.results.counters.at("parameters_admitted") == 1);
  CHECK(changed.results.counters.at("parameters_applied") == 1);
  CHECK(plain.results.counters.at("parameters_applied") == 0);
  if (counts_heap) CHECK(changed.results.counters.at("heap_calls") == 0);

  // Speeds by tick, from the fields of the drive's jobs.
  std::map<rt::Tick, double> in_force;
  std::map<rt::Tick, double> fastest;
  ReplayOptions replaying;
  replaying.on_job = [&](const rt::JobRecord& record, Runtime& runtime) {
    const auto& groups = runtime.parts().parameters().groups;
    if (record.group != groups[0]->group) return;
    const ParameterInfo* speed = runtime.parts().parameters().find("drive.max_speed_m_s");
    in_force[record.tick] = groups[0]->task->value().value[speed->index];
    fastest[record.tick] = runtime.vehicle().pose_task()->value().v_body_m_s[0];
  };
  const ReplayOutcome outcome = replay_log(log_path, replaying);
  CHECK(outcome.comparable);
  CHECK_FALSE(outcome.divergence);
  CHECK(outcome.results.digest == changed.results.digest);
  CHECK(outcome.results.counters.at("parameters_applied") == 1);
  CHECK(in_force.at(1999) == 0.5);
  CHECK(in_force.at(2000) == 0.2);
  CHECK(fastest.at(1999) > 0.4);
  CHECK(fastest.at(2999) < 0.25);
  set_heap_watch({});
}

TEST_CASE("every parameter of the ground robot can be changed, and every change shows in the digest") {
  const Runtime runtime(load_scene("ugv_hall"), own_vehicles(), RuntimeStart{});
  const std::string plain = run_live(own_vehicles(), make_simulated_robot, hall_options()).results.digest;
  std::size_t count = 0;
  for (const ParameterInfo& info : runtime.parts().parameters().all) {
    const std::string name(info.key().name);
    INFO(name);
    const double initial = info.owner->table.state().value[info.index];
    CHECK(initial >= info.key().low);
    CHECK(initial <= info.key().high);
    const double other = 0.9 * initial;
    const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot,
                                        hall_options({"script=[" + row(1, name, other) + "]"}));
    CHECK(run.results.digest != plain);
    CHECK(run.results.counters.at("parameters_applied") == 1);
    ++count;
  }
  CHECK(count == 9);
}

TEST_CASE("replays of changed runs agree on one thread and on many, and answer what if") {
  const TempFolder folder;
  std::mt19937 random(3);
  std::string script;
  const char* names[] = {"drive.max_speed_m_s", "odometry.scale", "attitude.acc_time_constant_s",
                         "map.max_range_m"};
  for (int i = 0; i < 40; ++i) {
    const double at_s = 2.9 * static_cast<double>(random() % 1000u) / 1000.0;
    const double value = 0.5 + static_cast<double>(random() % 1000u) / 2000.0;
    script += (script.empty() ? "" : ",") + row(at_s, names[random() % 4u], value);
  }
  LiveRunOptions options = hall_options({"script=[" + script + "]"});
  options.record = folder.file("many.lcm");
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  CHECK(run.results.counters.at("parameters_admitted") == 40);
  for (const bool threaded : {false, true}) {
    ReplayOptions replaying;
    replaying.threaded = threaded;
    const ReplayOutcome outcome = replay_log(options.record, replaying);
    CHECK(outcome.comparable);
    CHECK(outcome.results.digest == run.results.digest);
    CHECK(outcome.diverged_jobs == 0);
  }
  ReplayOptions what_if;
  what_if.overrides = {"odometry.track_width_m=0.5"};
  const ReplayOutcome other = replay_log(options.record, what_if);
  CHECK_FALSE(other.comparable);
  CHECK(other.results.counters.at("parameters_applied") == run.results.counters.at("parameters_applied"));

  // A log without one of the changes is not the same run.
  const std::string shorter = folder.file("shorter.lcm");
  rewrite_log(options.record, shorter, [](EditableEvent& event, std::size_t index) {
    return event.channel != "PARAMETER_control" || index != 3;
  });
  CHECK(replay_log(shorter).results.counters.at("samples_missing") > 0);
}

TEST_CASE("a live run takes changes at any moment and replays to its digest") {
  const TempFolder folder;
  std::mt19937 random(17);
  std::string script;
  for (int i = 0; i < 60; ++i) {
    const double at_s = 0.9 * static_cast<double>(random()) / 4294967296.0;
    script += (script.empty() ? "" : ",") +
              row(at_s, i % 3 == 0 ? "map.max_range_m" : "drive.max_speed_m_s", 0.6 + 0.01 * i);
  }
  LiveRunOptions options = hall_options({"script=[" + script + "]", "mission.start_s=0"});
  options.virtual_time = false;
  options.realtime = false;
  options.seconds = 1;
  options.record = folder.file("live.lcm");
  const LiveRunOutcome run = run_live_undisturbed(own_vehicles(), make_simulated_robot, options);
  CHECK(run.results.counters.at("parameters_admitted") + run.results.counters.at("parameters_full") == 60);
  CHECK(run.results.counters.at("parameters_admitted") > 20);
  for (const bool threaded : {false, true}) {
    ReplayOptions replaying;
    replaying.threaded = threaded;
    const ReplayOutcome outcome = replay_log(options.record, replaying);
    if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
    CHECK(outcome.results.digest == run.results.digest);
    CHECK(outcome.results.counters.at("parameters_applied") == run.results.counters.at("parameters_applied"));
  }
}

TEST_CASE("the desk refuses what must not be set, by reason, and records none of it") {
  Runtime runtime(load_scene("ugv_hall", {"limits.voxels=1024"}), own_vehicles(), RuntimeStart{});
  struct Count final : SampleSink {
    void sample(const std::string&, rt::Nanoseconds, std::span<const std::uint8_t>) override { ++samples; }
    int samples{};
  } recorded;
  for (const auto& port : runtime.parts().ports()) port->set_sink(&recorded);
  RequestDoor door(runtime);
  auto& desk = door.parameters();
  CHECK(desk.set("drive.max_sped_m_s", 0.3, 1) == Status::not_supported);
  CHECK(desk.set("map.voxel_m", 0.3, 1) == Status::not_supported);  // known, but not while running
  CHECK(desk.set("drive.max_speed_m_s", kNan, 1) == Status::not_finite);
  CHECK(desk.set("drive.max_speed_m_s", -std::numeric_limits<double>::infinity(), 1) == Status::not_finite);
  CHECK(desk.set("drive.max_speed_m_s", 10.5, 1) == Status::out_of_range);
  CHECK(recorded.samples == 0);
  for (std::uint32_t i = 0; i < kWaitingChanges; ++i)
    CHECK(desk.set("drive.max_speed_m_s", 0.1 + 0.01 * i, 1) == Status::ok);
  for (int i = 0; i < 100; ++i) CHECK(desk.set("drive.max_speed_m_s", 0.3, 1) == Status::full);
  CHECK(desk.set("map.max_range_m", 20, 1) == Status::ok);  // another group's ring
  const ParameterDeskCounters counters = desk.counters();
  CHECK(counters.admitted == kWaitingChanges + 1);
  CHECK(counters.unknown == 2);
  CHECK(counters.not_finite == 2);
  CHECK(counters.out_of_range == 1);
  CHECK(counters.full == 100);
  CHECK(recorded.samples == static_cast<int>(kWaitingChanges) + 1);
}

TEST_CASE("a setter's own refusal shows in the output: the map's ranges must not cross") {
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot,
                                      hall_options({"script=[" + row(1, "map.min_range_m", 30) + "]"}));
  CHECK(run.results.counters.at("parameters_admitted") == 1);
  CHECK(run.results.counters.at("parameters_applied") == 0);
  CHECK(run.results.counters.at("parameters_not_applied") == 1);
}

TEST_CASE("a script that cannot be run is refused at load, with the reason") {
  const auto says = [](const std::string& problem, const std::string& part) {
    INFO(problem);
    return problem.find(part) != std::string::npos;
  };
  CHECK(says(problem_of("[{at_s=1,set=\"drive.max_sped_m_s\",value=1}]"), "known: attitude."));
  CHECK(says(problem_of("[{at_s=1,set=\"drive.max_speed_m_s\",value=11}]"), "outside 0.01 .. 10 m/s"));
  CHECK(says(problem_of("[{at_s=1,set=\"drive.max_speed_m_s\",value=nan}]"), "outside"));
  CHECK(says(problem_of("[{at_s=1,set=\"drive.max_speed_m_s\",value=\"fast\"}]"), "value = a number"));
  CHECK(says(problem_of("[{at_s=-1,set=\"drive.max_speed_m_s\",value=1}]"), "at_s"));
  CHECK(says(problem_of("[{set=\"drive.max_speed_m_s\",value=1}]"), "at_s"));
  CHECK(says(problem_of("[{at_s=1,value=1}]"), "needs set"));
  CHECK(says(problem_of("[{at_s=1,set=\"drive.max_speed_m_s\",value=1,why=2}]"), "unknown key"));
  CHECK(says(problem_of("3"), "must be a list"));
  CHECK(says(problem_of("[3]"), "must be a table"));
  CHECK(problem_of("[]").empty());
  const std::string toml =
      "[scene]\nname = \"x\"\nvehicle = \"ugv\"\n\n[[script]]\nat_s = 1.0\nset = \"no.such\"\nvalue = 1\n";
  const std::string problem = message_of<ProfileError>(
      [&] { static_cast<void>(Runtime(Profile(toml, "x.toml"), own_vehicles(), RuntimeStart{})); });
  CHECK(says(problem, "x.toml:5"));
}

TEST_CASE("a group's first parameter comes before its first task, and only numbers can be parameters") {
  struct Late final : Vehicle {
    explicit Late(VehicleBuilder& builder) {
      const rt::GroupId group = builder.group("g", 100);
      builder.task<rt::PoseEstimate>(group, "t", 1, [](rt::JobContext&, rt::PoseEstimate&) {});
      builder.parameter(group, "g.gain", {1, 0, 2, "", "a gain"}, &gain);
    }
    double gain{};
  };
  struct Text final : Vehicle {
    explicit Text(VehicleBuilder& builder) {
      const rt::GroupId group = builder.group("g", 100);
      builder.profile().flag("g.on", true, "a switch");
      builder.parameter(group, "g.on", [](double) { return Status::ok; });
    }
  };
  const auto problem = [](const VehicleFactory& factory) {
    const VehicleRegistry vehicles{{"v", factory}};
    return message_of<ProfileError>([&] {
      static_cast<void>(
          Runtime(Profile("[scene]\nname=\"s\"\nvehicle=\"v\"\n", "s"), vehicles, RuntimeStart{}));
    });
  };
  CHECK(problem([](VehicleBuilder& b) {
          return std::make_unique<Late>(b);
        }).find("before the group's first") != std::string::npos);
  CHECK(problem([](VehicleBuilder& b) { return std::make_unique<Text>(b); }).find("only a number") !=
        std::string::npos);
}

TEST_CASE("a secret must be whole and private") {
  const TempFolder folder;
  const std::string good = folder.write("good", "000102030405060708090A0b0c0d0e0f\n");
  std::filesystem::permissions(good, std::filesystem::perms::owner_read);
  CHECK(read_secret(good)[10] == 10);
  CHECK(read_secret(good)[15] == 15);
  const auto problem = [](const std::string& path) {
    return message_of<ProfileError>([&] { static_cast<void>(read_secret(path)); });
  };
  for (const std::string& text : {std::string(), std::string(31, '0'), std::string(33, '0'),
                                  std::string(31, '0') + "g", std::string(200, '0')}) {
    const std::string path = folder.write("bad", text);
    std::filesystem::permissions(path,
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    CHECK(problem(path).find("32 hexadecimal digits") != std::string::npos);
  }
  const std::string open = folder.write("open", std::string(32, '0'));
  std::filesystem::permissions(open,
                               std::filesystem::perms::owner_read | std::filesystem::perms::others_read);
  CHECK(problem(open).find("chmod 600") != std::string::npos);
  CHECK(problem(folder.file("none")).find("cannot be read") != std::string::npos);
  // A FIFO that nobody writes to, a folder, a device and a link: refused at once, and never waited for.
  const std::string fifo = folder.file("fifo");
  REQUIRE(::mkfifo(fifo.c_str(), 0600) == 0);
  CHECK(problem(fifo).find("no regular file") != std::string::npos);
  const std::string drawer = folder.file("drawer");
  REQUIRE(::mkdir(drawer.c_str(), 0700) == 0);
  CHECK(problem(drawer).find("no regular file") != std::string::npos);
  CHECK(problem("/dev/zero").find("no regular file") != std::string::npos);
  std::filesystem::create_symlink(good, folder.file("link"));
  CHECK(problem(folder.file("link")).find("is a link") != std::string::npos);
  // Somebody else's: only root can make one here.
  const std::string theirs = folder.write("theirs", std::string(32, '0'));
  REQUIRE(::chmod(theirs.c_str(), 0600) == 0);
  if (::chown(theirs.c_str(), 12345, static_cast<gid_t>(-1)) == 0)
    CHECK(problem(theirs).find("belongs to user 12345") != std::string::npos);
  CHECK(unguessable_number() != unguessable_number());
  CHECK(unguessable_number() > 0);
}
