// SPDX-License-Identifier: BSD-3-Clause
// Every name that docs/command-line.md offers a gate, in a live run and in the check of its log: broken by a
// limit that cannot be kept, kept by a generous one, and the robot's own figure, whoever replays it.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "firmware_like/log/recorded_times.hpp"
#include "firmware_like/scene/profile.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"
#include "toolchain/judge/gate.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// A live run of the hall with its log, once a program.
struct LiveHall {
  LiveHall() {
    watch_heap();
    LiveRunOptions options;
    options.scene = "ugv_hall";
    options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768"};
    options.seconds = 1;
    options.realtime = false;
    options.record = log;
    options.lcm_url = "none";
    run = run_live(own_vehicles(), make_simulated_robot, options);
    judge(run);
    ReplayOutcome replayed = replay_log(log);
    judge(replayed);
    checked = std::move(replayed.results);
    set_heap_watch({});
  }
  TempFolder folder;
  std::string log = folder.file("live.lcm");
  LiveRunOutcome run;
  Results checked;
};

const LiveHall& live_hall() {
  static const LiveHall hall;
  return hall;
}

// [max] or [min] with one bound; every part of the name in quotes, for some have blanks in them.
std::string bound(const char* table, const std::string& name, double limit) {
  std::string key = "\"";
  for (const char letter : name) key += letter == '.' ? std::string("\".\"") : std::string(1, letter);
  char number[40];
  std::snprintf(number, sizeof number, "%.17e", limit);
  return std::string("[") + table + "]\n" + key + "\" = " + number + "\n";
}

std::size_t broken(const TempFolder& folder, const std::string& text, const Results& results) {
  return Gate(folder.write("gate.toml", text)).judge(results).size();
}

std::string refusal(const std::string& name, const Results& results) {
  const TempFolder folder;
  return message_of<ProfileError>([&] { broken(folder, bound("max", name, 1e300), results); });
}

std::vector<std::string> words_in(const std::string& cell) {
  std::vector<std::string> words;
  const std::regex code("`([^`]+)`");
  for (std::sregex_iterator word(cell.begin(), cell.end(), code), end; word != end; ++word)
    words.push_back((*word)[1]);
  return words;
}

// The table of the page: what stands in its first column, with each of the second.
std::vector<std::string> offered_names() {
  std::ifstream page(SORTIE_SOURCE_DIR "/docs/command-line.md");
  REQUIRE(page);
  std::vector<std::string> names;
  bool in_gates = false;
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("## ", 0) == 0) in_gates = line == "## Gates";
    if (!in_gates || line.rfind("| `", 0) != 0) continue;
    std::istringstream cells(line);
    std::string nothing;
    std::string first;
    std::string second;
    std::getline(cells, nothing, '|');
    std::getline(cells, first, '|');
    std::getline(cells, second, '|');
    for (const std::string& prefix : words_in(first)) {
      const std::vector<std::string> figures = words_in(second);
      if (figures.empty()) names.push_back(prefix);
      for (const std::string& figure : figures) names.push_back(prefix + "." + figure);
    }
  }
  return names;
}

std::regex pattern_of(const std::string& name) {
  std::string pattern = std::regex_replace(name, std::regex("\\."), "\\.");
  pattern = std::regex_replace(pattern, std::regex("NAME|CAUSE"), "[^.]+");
  return std::regex(pattern);
}

}  // namespace

TEST_CASE("every name that the page offers a gate can fail and can pass, live and from the log") {
  const std::vector<std::string> offered = offered_names();
  REQUIRE(offered.size() > 50);
  const TempFolder folder;
  for (const bool from_log : {false, true}) {
    const Results& results = from_log ? live_hall().checked : live_hall().run.results;
    INFO((from_log ? "from the log" : "live"));
    CHECK(results.live.known);
    CHECK(results.live.why_no_causes.empty());
    const GateFigures figures = gate_figures(results);
    double latest = 0;
    double slowest = 0;
    for (const GroupResult& group : results.groups) {
      latest = std::max(latest, group.late_max_us);
      slowest = std::max(slowest, group.response_max_us);
    }
    CHECK(figures.known.at("all.late_max_us") == latest);
    CHECK(figures.known.at("all.response_max_us") == slowest);
    std::set<std::string> planted;
    for (const std::string& name : offered) {
      std::size_t found = 0;
      const std::regex pattern = pattern_of(name);
      for (const auto& [figure, value] : figures.known) {
        if (!std::regex_match(figure, pattern)) continue;
        ++found;
        if (!planted.insert(figure).second) continue;
        CAPTURE(figure, value);
        REQUIRE(std::isfinite(value));
        const double beyond = 1 + std::abs(value);
        CHECK(broken(folder, bound("max", figure, value - beyond), results) == 1);
        CHECK(broken(folder, bound("min", figure, value + beyond), results) == 1);
        CHECK(broken(folder, bound("max", figure, value + beyond), results) == 0);
        CHECK(broken(folder, bound("min", figure, value - beyond), results) == 0);
      }
      INFO(name);
      CHECK(found > 0);  // the page offers nothing that is not there
    }
    for (const auto& [figure, value] : figures.known) {
      INFO(figure << " is not on the page");
      CHECK(planted.count(figure) == 1);
    }
    for (const char* word : {"digest", "scene", "vehicle"}) {
      CHECK(broken(folder, std::string("[equal]\n") + word + " = \"planted\"\n", results) == 1);
    }
    CHECK(broken(folder, "[equal]\ndigest = \"" + results.digest + "\"\n", results) == 0);
  }
}

TEST_CASE("the log gives the gate the figures that the live run gave it") {
  const GateFigures live = gate_figures(live_hall().run.results);
  const GateFigures checked = gate_figures(live_hall().checked);
  const bool skipped = live_hall().run.results.counters.at("skipped_releases") != 0;
  int same = 0;
  for (const auto& [name, value] : live.known) {
    const bool of_robot = name.rfind("tasks.", 0) == 0 || name.rfind("groups.", 0) == 0 ||
                          name.rfind("all.", 0) == 0 || name.rfind("chains.", 0) == 0 ||
                          name.rfind("errors.", 0) == 0;
    if (!of_robot) continue;
    // A release that was left out is known to the log only by the job that came after it.
    const bool by_release = name.find("late_") != std::string::npos ||
                            name.find("response_max") != std::string::npos ||
                            name.find("skipped") != std::string::npos;
    if (skipped && by_release) continue;
    CAPTURE(name);
    REQUIRE(checked.known.count(name) == 1);
    ++same;
    if (name.rfind("chains.", 0) != 0) {
      CHECK(checked.known.at(name) == Approx(value).epsilon(1e-12));
    } else if (name.find(".p") == std::string::npos) {           // a percentile is that of a bucket
      CHECK(std::abs(checked.known.at(name) - value) <= 1.001);  // a log notes arrivals in whole microseconds
    }
  }
  CHECK(same > 80);
  for (const char* name : kLiveCounters) {
    INFO(name);
    const auto& counters = live_hall().run.results.counters;
    if (counters.count(name) == 0) continue;  // heap calls are counted only where the trap works
    CHECK(live_hall().checked.counters.at(name) == counters.at(name));
  }
}

TEST_CASE("times of the replaying machine are never taken for the robot's, slow or fast") {
  const TempFolder folder;
  for (const bool slow_robot : {false, true}) {
    INFO((slow_robot ? "slow robot, fast desk" : "fast robot, slow desk"));
    stalls = slow_robot ? Stalls{30'000, 0, 0} : Stalls{};
    LiveRunOptions options;
    options.scene = stall_scene(folder);
    options.seconds = 0.4;
    options.realtime = false;
    options.record = folder.file("stall.lcm");
    options.lcm_url = "none";
    const Results robot = run_live(stall_vehicles(), nullptr, options).results;
    stalls = slow_robot ? Stalls{} : Stalls{30'000, 0, 0};
    const LogFile log(options.record);
    const Results desk = replay(log, stall_vehicles(), {}).results;
    stalls = {};
    REQUIRE(desk.live.known);
    const GateFigures figures = gate_figures(desk);
    CHECK(figures.known.at("tasks.quick.max_us") == robot.live.tasks.at(0).max_us);
    CHECK(figures.known.at("here.tasks.quick.max_us") == desk.tasks.at(0).max_us);
    CHECK(figures.known.at("counters.over_budget") == static_cast<double>(robot.counters.at("over_budget")));
    if (slow_robot) CHECK(figures.known.at("groups.fast.response_max_us") >= 30'000);
    if (!slow_robot) CHECK(figures.known.at("here.max_us") >= 30'000);
  }
}

TEST_CASE("what the log does not hold of the robot is refused with the cure") {
  const std::vector<std::string> names{"tasks.map.max_us",
                                       "all.max_us",
                                       "groups.control.late_max_us",
                                       "all.response_max_us",
                                       "groups.control.margin_us",
                                       "counters.over_budget",
                                       "chains.imu_to_drive.measured_finished.max_us",
                                       "groups.control.delays.start.outliers"};
  const auto all_say = [&names](const Results& results, const std::string& words) {
    for (const std::string& name : names) {
      const std::string said = refusal(name, results);
      INFO(name << ": " << said);
      CHECK(mentions(said, "gate.toml:2: " + name));
      CHECK(mentions(said, words));
    }
  };
  all_say(two_seconds().run.results, "in simulated time, where nothing is late; leave out --virtual");
  all_say(replay_log(two_seconds().log).results,
          "was recorded in simulated time, where nothing is late; record a live run");
  CHECK(mentions(refusal("tasks.map.max_us", two_seconds().run.results),
                 "here.tasks.map.max_us is the figure"));
  CHECK(mentions(refusal("speed", two_seconds().run.results), "here.speed"));

  ReplayOptions what_if;
  what_if.overrides = {"map.voxel_m=0.2"};
  all_say(replay_log(live_hall().log, what_if).results, "leave out --scene and --set");

  // Times of some jobs are lost, not only of the last.
  const TempFolder folder;
  const std::string thin = folder.file("thin.lcm");
  rewrite_log(live_hall().log, thin, [](EditableEvent& event, std::size_t index) {
    return event.channel != drivers::kChannelTiming || index % 100 != 50;
  });
  all_say(replay_log(thin).results, "record the run again");

  // Killed: the end was never told, but every job's times are there.
  const std::string killed = folder.file("killed.lcm");
  rewrite_log(live_hall().log, killed,
              [](EditableEvent& event, std::size_t) { return event.channel != drivers::kChannelEvent; });
  const Results cut = replay_log(killed).results;
  CHECK(cut.live.known);
  CHECK(cut.groups[0].late_max_us == live_hall().checked.groups[0].late_max_us);
  CHECK(mentions(refusal("groups.control.margin_us", cut), "ends before its run told"));
  CHECK(mentions(refusal("groups.control.delays.start.outliers", cut), "ends before its run told"));

  ReplayOptions part;
  part.from = "0.5";
  const Results half = replay_log(live_hall().log, part).results;
  CHECK(half.live.known);
  CHECK(half.live.tasks.at(0).count < live_hall().checked.live.tasks.at(0).count);
  CHECK(mentions(refusal("groups.control.margin_us", half), "leave out --from and --to"));
}

TEST_CASE("a task that the ladder left out has no time in the result, whatever the log notes for it") {
  const TempFolder folder;
  const std::string shed = folder.file("shed.lcm");
  rewrite_log(live_hall().log, shed, [](EditableEvent& event, std::size_t) {
    rt::JobRecord tick;
    if (event.channel != drivers::kChannelTick) return true;
    REQUIRE(drivers::decode(event.bytes, tick) == Status::ok);
    tick.level = rt::kTopLevel;
    std::size_t size = 0;
    event.bytes.resize(drivers::encoded_bytes(tick));
    REQUIRE(drivers::encode(tick, event.bytes, size) == Status::ok);
    return true;
  });
  const Results& whole = live_hall().checked;
  const Results left = replay_log(shed).results;
  REQUIRE(left.live.known);
  REQUIRE(left.live.tasks.size() == whole.live.tasks.size());
  int without = 0;
  for (std::size_t i = 0; i < whole.live.tasks.size(); ++i) {
    CAPTURE(left.live.tasks[i].name);
    const bool ran = left.tasks[i].count != 0;  // of the replay itself
    CHECK(left.live.tasks[i].count == (ran ? whole.live.tasks[i].count : 0));
    without += ran ? 0 : 1;
  }
  CHECK(without >= 1);
}
