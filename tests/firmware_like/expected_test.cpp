// SPDX-License-Identifier: BSD-3-Clause
// The change indicator: digests and poses of fixed runs, equal on every compiler and processor, and the
// figures that the recorded data sets must reach.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "rt/fields.hpp"
#include "tests/firmware_like/expected_support.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/import/importer.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// Imports recorded data and replays it, or says that it is not there.
bool replay_recorded(const std::string& kind, const std::string& path, const ReplayOptions& options,
                     ReplayOutcome& outcome) {
  const std::string data = std::string(SORTIE_DATA_DIR) + "/" + path;
  if (!std::filesystem::exists(data)) {
    WARN("skipped: no recorded data at " << data);
    return false;
  }
  const TempFolder folder;
  std::ostringstream notes;
  ImportOptions import;
  import.kind = kind;
  import.path = data;
  import.out = folder.file("imported.lcm");
  import.notes = &notes;
  static_cast<void>(import_log(import));
  outcome = replay_log(import.out, options);
  return true;
}

ReplayOptions scene(const std::string& name, std::vector<std::string> overrides = {}) {
  ReplayOptions options;
  options.scene = name;
  options.overrides = std::move(overrides);
  return options;
}

PoolResult voxels(const Results& results) {
  for (const PoolResult& pool : results.pools) {
    if (pool.name == "voxels") return pool;
  }
  FAIL("no pool of voxels");
  return {};
}

void check_points_add_up(const Results& results) {
  std::uint64_t sum = 0;
  for (const char* name : {"points_used", "points_not_finite", "points_too_near", "points_too_far",
                           "points_on_robot", "points_unplaced", "points_outside", "points_out_of_grid",
                           "points_pool_full", "points_scan_full", "points_bad_pose"})
    sum += results.counters.at(name);
  CHECK(results.counters.at("points_in") == sum);
}

}  // namespace

TEST_CASE("five seconds of the simulated hall give the committed digest and poses", "[expected]") {
  const TempFolder folder;
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.seconds = 5;
  options.virtual_time = true;
  options.record = folder.file("hall.lcm");
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  check_expected_digest("ugv_hall_virtual_5s", run.results.digest);

  // All fields of the last outputs once a second: where the digest says that something differs, this says
  // what.
  std::ostringstream table;
  table << "tick,task,field,value\n";
  ReplayOptions again;
  again.on_job = [&table](const rt::JobRecord& record, Runtime& runtime) {
    if (record.tick % 1000 >= 100) return;  // one slow and one fast release each second
    const rt::Group& group = runtime.executive().group(record.group);
    if (record.tick % 1000 >= group.timing.period) return;
    std::uint32_t offset = 0;
    for (const rt::TaskBase* task : group.tasks) {
      if (offset + task->output_bytes() > record.field_bytes) break;
      struct Line {
        std::ostringstream* table;
        std::string prefix;
      } line{&table, std::to_string(record.tick) + "," + task->name()};
      task->describe(record.fields + offset, {&line, [](void* self, const char* name, int index, double value,
                                                        std::uint64_t, std::uint32_t) {
                                                if (std::string(name) == "covariance" && index % 7 != 0)
                                                  return;  // the diagonal is enough to read
                                                char number[40];
                                                std::snprintf(number, sizeof number, "%.17g", value);
                                                auto& to = *static_cast<Line*>(self);
                                                *to.table << to.prefix << "," << name;
                                                if (index >= 0) *to.table << "[" << index << "]";
                                                *to.table << "," << number << "\n";
                                              }});
      offset += task->output_bytes();
    }
  };
  const ReplayOutcome replayed = replay_log(options.record, again);
  CHECK(replayed.results.digest == run.results.digest);
  check_expected_text("ugv_hall_virtual_5s.csv", table.str());
}

TEST_CASE("thirteen seconds with contacts give the committed digest, over a pallet and down again",
          "[expected]") {
  LiveRunOptions options;
  options.scene = "ugv_pallet";
  options.seconds = 13;
  options.virtual_time = true;
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  double highest = 0;
  for (const TimedPose& point : run.truth) highest = std::max(highest, point.p[2]);
  CHECK(highest > 0.1);  // the pallet is 0.133 m high
  CHECK(std::fabs(run.truth.back().p[2]) < 0.01);
  CHECK(run.truth.back().p[0] > 2.0);
  CHECK(run.results.counters.at("bench_rejected_steps") == 0);
  CHECK(run.results.counters.at("bench_penetration_um") < 1000);
  CHECK(run.results.counters.at("bench_flipper_commands") > 500);
  check_expected_digest("ugv_pallet_virtual_13s", run.results.digest);
}

TEST_CASE("the Husky log stays within 3.3 m of GPS over 195 m", "[expected]") {
  ReplayOutcome outcome;
  if (!replay_recorded("husky", "husky_skid", scene("skid_outdoor"), outcome)) return;
  EvaluationOptions aligned;
  aligned.align = Alignment::se2;
  judge(outcome, aligned);
  CHECK(outcome.results.errors.at("ate_rmse_m") <= 3.3);
  check_expected_digest("husky", outcome.results.digest);
}

TEST_CASE("the lawn mower stays within 2.0 m of RTK GPS over 1,861 m without alignment",
          "[expected][heavy]") {
  ReplayOutcome outcome;
  if (!replay_recorded("plaza", "plaza_odom", scene("skid_outdoor"), outcome)) return;
  judge(outcome);
  CHECK(outcome.results.errors.at("ate_rmse_m") <= 2.0);
  check_expected_digest("plaza", outcome.results.digest);
}

TEST_CASE("a recorded walk loses no point, and a smaller pool refuses and counts the rest",
          "[expected][heavy]") {
  const std::string thin = "lidar_os64/os64_thin4_000_109.rls";
  ReplayOutcome roomy;
  if (!replay_recorded("rls", thin, scene("building_walk"), roomy)) return;
  CHECK(roomy.results.counters.at("scans") == 110);
  CHECK(voxels(roomy.results).refused == 0);
  CHECK(voxels(roomy.results).high_water > 100'000);
  CHECK(roomy.results.counters.at("segments") > 0);
  check_points_add_up(roomy.results);
  check_expected_digest("walk_thin", roomy.results.digest);

  ReplayOutcome tight;
  REQUIRE(replay_recorded(
      "rls", thin, scene("building_walk", {"limits.voxels=65536", "map.when_full=\"refuse\""}), tight));
  CHECK(tight.results.counters.at("scans") == 110);
  CHECK(voxels(tight.results).high_water == 65'536);
  CHECK(voxels(tight.results).refused > 0);
  CHECK(tight.results.counters.at("points_pool_full") == voxels(tight.results).refused);
  CHECK(tight.results.counters.at("points_in") == roomy.results.counters.at("points_in"));
  CHECK(tight.results.counters.at("points_used") + tight.results.counters.at("points_pool_full") ==
        roomy.results.counters.at("points_used"));
  check_points_add_up(tight.results);
  check_expected_digest("walk_thin_pool_full", tight.results.digest);
}

TEST_CASE("all 122 scans of both lidar files go into one map", "[expected][heavy]") {
  ReplayOutcome outcome;
  if (!replay_recorded("rls", "lidar_os64", scene("building_walk"), outcome)) return;
  CHECK(outcome.results.counters.at("scans") == 122);
  CHECK(outcome.results.counters.at("scans_unplaced") == 0);
  CHECK(outcome.results.counters.at("refused_samples") == 0);
  check_points_add_up(outcome.results);
  check_expected_digest("walk", outcome.results.digest);
}
