// SPDX-License-Identifier: BSD-3-Clause
// Run time over time, several runs on one page, and what a scene leaves out.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "estimators/obstacle_modes.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/judge/job_timeline.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/plots.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

std::size_t times_in(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + part.size())) ++n;
  return n;
}

ReportInput run_of(const std::string& scene, double radius_m) {
  ReportInput input;
  input.results.scene = scene;
  input.results.vehicle = "ugv";
  input.results.digest = "digest of " + scene;
  input.results.duration_s = 10;
  input.results.errors = {{"ate_rmse_m", radius_m}, {"distance_m", 3.0}};
  input.results.tasks.resize(1);
  input.results.tasks[0].p99_us = 25;
  input.results.tasks[0].budget_us = 50;
  for (int i = 0; i < 100; ++i) {
    TimedPose pose;
    pose.stamp_ns = i;
    pose.p[0] = radius_m * i;
    pose.flags = rt::kTruthPosition;
    input.estimate.push_back(pose);
  }
  return input;
}

}  // namespace

TEST_CASE(
    "The longest of each span is that of a count by hand, whatever the order and the length of the run") {
  const std::uint64_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  bool same = true;
  for (int trial = 0; trial < 50; ++trial) {
    const double end_s = std::pow(10.0, static_cast<double>(random() % 6));
    SpanMaxima maxima;
    std::vector<std::pair<double, double>> values;
    for (int i = 0; i < 2000; ++i) {
      const double time_s = end_s * static_cast<double>(random() >> 11) * 0x1p-53;
      values.emplace_back(time_s, static_cast<double>(random() % 1000) - 500.0);
      maxima.add(time_s, values.back().second);
    }
    const std::vector<SpanMaxima::Span> spans = maxima.spans();
    std::uint64_t counted = 0;
    for (const SpanMaxima::Span& span : spans) {
      double most = -1e300;
      std::uint64_t n = 0;
      for (const auto& [time_s, value] : values) {
        if (time_s < span.from_s || time_s >= span.to_s) continue;
        most = std::fmax(most, value);
        ++n;
      }
      same = same && n == span.count && most == span.most;
      counted += span.count;
    }
    same = same && counted == values.size() && spans.size() <= SpanMaxima::kMost;
    // As fine as they may be: half as long spans would have been too many.
    same = same && (spans[0].to_s - spans[0].from_s <= 0.1 ||
                    end_s >= 0.25 * SpanMaxima::kMost * (spans[0].to_s - spans[0].from_s));
  }
  CHECK(same);
  SpanMaxima none;
  none.add(std::nan(""), 1);
  none.add(-1.0, 1);
  none.add(INFINITY, 1);
  CHECK(none.spans().empty());
}

TEST_CASE(
    "A run over a pallet has a timeline with the odometry's modes, and its page names what is left out") {
  const TempFolder folder;
  const std::string log = folder.file("pallet.lcm");
  LiveRunOptions options;
  options.scene = "ugv_pallet";
  options.seconds = 8;
  options.virtual_time = true;
  options.record = log;
  options.lcm_url = "none";
  static_cast<void>(run_live(own_vehicles(), make_simulated_robot, options));
  JobTimeline timeline;
  std::map<std::string, std::uint64_t> jobs;
  std::uint64_t planar = 0;
  ReplayOptions replay;
  replay.on_job = [&](const rt::JobRecord& record, Runtime& runtime) {
    timeline.job(record, runtime);
    ++jobs[runtime.executive().group(record.group).spec.name];
  };
  const ReplayOutcome outcome = replay_log(log, replay);
  for (const GroupTimeline& group : timeline.groups()) {
    INFO(group.name);
    std::uint64_t counted = 0;
    for (const SpanMaxima::Span& span : group.job_us.spans()) counted += span.count;
    CHECK(counted == jobs[group.name]);
    CHECK(counted > 0);
  }
  for (const ModeChange& change : timeline.modes())
    planar += change.mode == static_cast<std::uint32_t>(estimators::ObstacleMode::planar) ? 1 : 0;
  CHECK(timeline.modes().size() >= 4);
  CHECK(planar >= 1);
  const Plot plot = plot_timeline(timeline);
  std::size_t bands = 0;
  for (const Series& series : plot.series) bands += series.mark == Mark::bands ? series.x.size() : 0;
  CHECK(bands + planar == timeline.modes().size());

  ReportInput input;
  input.results = outcome.results;
  input.timeline = plot;
  CHECK(outcome.results.left_out == std::vector<std::string>{"way", "locate", "recognise", "recognise_images",
                                                             "ssl", "elevation", "cloud"});
  CHECK(outcome.results.profile_hash.size() == 16);
  const std::string page = render_report(input);
  CHECK(xml_fault(page).empty());
  CHECK(page.find("Left out") != std::string::npos);
  CHECK(page.find("Longest job of each group over time") != std::string::npos);
  CHECK(page.find(outcome.results.profile_hash) != std::string::npos);
}

TEST_CASE("Several runs share a page: a table with links, one picture of all ways, then each run") {
  std::vector<ReportInput> inputs{run_of("first <scene>", 0.25), run_of("second", 0.5)};
  Plot ground;
  ground.series.push_back({"floor", Mark::dots, kGrey, 1.6, false, {0, 1}, {0, 1}});
  ground.series.push_back({"its own path", Mark::line, 1, 1.6, false, {0, 1}, {0, 1}});
  const std::string page = render_report(inputs, ground);
  CHECK(xml_fault(page).empty());
  CHECK(times_in(page, "href=\"#run") == 2);
  CHECK(times_in(page, "id=\"run1\"") == 1);
  CHECK(times_in(page, "id=\"run2\"") == 1);
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("first &lt;scene&gt; + second") != std::string::npos);
  CHECK(times_in(page, "digest of second") == 2);  // in the table, and under its run
  CHECK(page.find("its own path") == std::string::npos);
  CHECK(page.find("50 %") != std::string::npos);
  // One run alone is the page that it always was.
  inputs.pop_back();
  CHECK(render_report(inputs, ground) == render_report(inputs.front()));
  CHECK(xml_fault(render_report(std::vector<ReportInput>(3), Plot{})).empty());
}
