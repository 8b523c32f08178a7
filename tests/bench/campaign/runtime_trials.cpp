// SPDX-License-Identifier: BSD-3-Clause
// The whole runtime under the campaign: a log of hostile samples, replayed by the scene of the hall.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "firmware_like/log/replay.hpp"
#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/heap_watch.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"
#include "toolchain/import/log_builder.hpp"

namespace sortie::bench {

namespace {

// Receipts go forward, as a recorder writes them; stamps do what they like.
void fill_log(std::span<const CampaignOp> ops, toolchain::LogBuilder& log, std::uint64_t (&samples)[3]) {
  rt::Nanoseconds receipt = 1'000'000'000;
  CampaignClock clock{receipt};
  log.add(receipt, rt::ImuSample{receipt, {0, 0, 0.01}, {0, 0, 9.81}, rt::kImuGyr | rt::kImuAcc});
  samples[0] = 1;
  double left = 0;
  double right = 0;
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    receipt += 5'000'000;
    const rt::Nanoseconds stamp = clock.step(op);
    if (op.kind % 6 < 3) {
      log.add(receipt,
              rt::ImuSample{stamp, {v[0], v[1], v[2]}, {v[3], v[4], 9.81 + v[5]}, rt::kImuGyr | rt::kImuAcc});
      ++samples[0];
    } else if (op.kind % 6 < 5) {
      left += 0.01 * v[0];
      right += 0.01 * v[1];
      log.add(receipt, rt::TrackSample{stamp, left, right, 0});
      ++samples[1];
      if (!std::isfinite(left + right)) left = right = 0.0;
    } else {
      rt::ScanHeader header;
      header.stamp_ns = stamp;
      std::vector<rt::ScanPoint> points(v[6] > 0.7 ? 0 : 1 + whole_of(v[6], 600));
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double a = 0.01 * static_cast<double>(i);
        points[i] = {static_cast<float>(8.0 * v[0] + a), static_cast<float>(8.0 * v[1] + v[3] * a),
                     static_cast<float>(v[2]), 0, 0};
      }
      log.add(receipt, header, std::move(points));
      ++samples[2];
    }
  }
}

std::string log_path() {
  return (std::filesystem::temp_directory_path() / ("sortie-campaign-" + std::to_string(::getpid()) + ".lcm"))
      .string();
}

}  // namespace

CampaignOutcome run_runtime_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  toolchain::LogBuilder builder;
  std::uint64_t samples[3]{};
  fill_log(ops, builder, samples);
  const std::string path = log_path();
  toolchain::ImportReport report;
  builder.write(path, "campaign", report);
  firmware::ReplayOutcome outcome;
  {
    firmware::watch_heap();
    const std::uint64_t before = rt::posix::heap_trap_calls();
    const firmware::LogFile log(path);
    firmware::ReplayOptions options;
    options.scene = "ugv_hall";
    options.overrides = {"limits.voxels=2048", "limits.scan_points=512", "limits.scan_buffers=2"};
    options.on_job = [&trial](const rt::JobRecord&, firmware::Runtime&) { trial.need(true, ""); };
    outcome = firmware::replay(log, firmware::own_vehicles(), options);
    trial.need(rt::posix::heap_trap_calls() == before, "a task called the heap");
  }
  std::filesystem::remove(path);
  const auto& counters = outcome.results.counters;
  const auto at = [&counters](const std::string& name) {
    const auto found = counters.find(name);
    return found == counters.end() ? std::uint64_t{0} : found->second;
  };
  trial.need(!counters.empty() && outcome.results.ticks > 0, "nothing was run");
  std::uint64_t points = 0;
  for (const char* name : {"points_used", "points_not_finite", "points_too_near", "points_too_far",
                           "points_on_robot", "points_unplaced", "points_outside", "points_out_of_grid",
                           "points_pool_full", "points_scan_full", "points_bad_pose"})
    points += at(name);
  trial.need(points == at("points_in"), "points and counters do not add up");
  for (const firmware::PoolResult& pool : outcome.results.pools)
    trial.need(pool.high_water <= pool.capacity, "a pool is fuller than it is large");
  for (const firmware::TimedPose& pose : outcome.estimate) {
    for (const double p : pose.p) trial.need(std::isfinite(p), "the estimated trajectory is not finite");
  }
  for (const char digit : outcome.results.digest) trial.fold(static_cast<std::uint64_t>(digit));
  trial.count_many(at("points_in"), at("points_used"), points - at("points_used"));
  return trial.end();
}

}  // namespace sortie::bench
