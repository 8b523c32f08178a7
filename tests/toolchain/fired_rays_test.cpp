// SPDX-License-Identifier: BSD-3-Clause
// The picture of fired rays and the table beside it: each ray where it went, each figure what the jobs say.
#include <catch2/catch.hpp>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"
#include "tests/firmware_like/ssl_rig.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/judge/fired_rays.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/map_plot.hpp"

namespace sortie::testing {
namespace {

const toolchain::Series* series_named(const toolchain::Plot& plot, const std::string& name) {
  for (const toolchain::Series& series : plot.series)
    if (series.name == name) return &series;
  return nullptr;
}

std::string value_of(const std::vector<toolchain::FigureRow>& rows, const std::string& name) {
  for (const toolchain::FigureRow& row : rows)
    if (row.name == name) return row.value;
  return "no such row";
}

// Two commands of three rays, two seconds apart; the second one's last ray meets nothing.
toolchain::FiredRays two_commands() {
  toolchain::FiredRays fired;
  for (std::uint32_t command = 1; command <= 2; ++command) {
    for (int i = 0; i < 3; ++i) {
      toolchain::FiredRay ray;
      ray.at_ns = (command - 1) * 2'000'000'000LL + i * 1'000'000;
      ray.command = command;
      ray.from_m[0] = command;
      ray.to_m[0] = command + 4.0;
      ray.to_m[1] = i - 1.0;
      ray.hit = command == 1 || i != 2;
      fired.rays.push_back(ray);
    }
  }
  return fired;
}

}  // namespace

TEST_CASE(
    "the picture of fired rays shows each return once, the newest over older ones, and silence dashed") {
  toolchain::FiredRays fired = two_commands();
  toolchain::FiredRay over = fired.rays[4];  // the second command, at (6, 0)
  over.to_m[0] = fired.rays[1].to_m[0];      // met what the first command's middle ray had met
  fired.rays.push_back(over);
  const std::vector<toolchain::MapPoint> occupied{{5.0, 0.0, 0.1}, {5.0, 0.0, 1.7}, {900.0, 0.0, 0.0}};
  const toolchain::Plot plot = toolchain::plot_fired_rays(fired, occupied, {});
  const toolchain::Series* grey = series_named(plot, "occupied");
  const toolchain::Series* old = series_named(plot, "0.0 to 0.5 s");
  const toolchain::Series* fresh = series_named(plot, "1.5 to 2.0 s");
  REQUIRE(grey != nullptr);
  REQUIRE(old != nullptr);
  REQUIRE(fresh != nullptr);
  CHECK(grey->x.size() == 1);   // one column of cells, and what lies far outside is left out
  CHECK(old->x.size() == 2);    // the middle one was seen again since
  CHECK(fresh->x.size() == 3);  // two of their own, and that one
  std::size_t lines = 0;
  std::size_t dashed = 0;
  for (const toolchain::Series& series : plot.series) {
    if (!series.name.empty()) continue;
    (series.dashed ? dashed : lines) += series.x.size() / 3;
    for (std::size_t i = 0; i + 2 < series.x.size(); i += 3) {
      CHECK(std::fabs(series.x[i + 1] - series.x[i]) > 2.0);
      CHECK(std::isnan(series.x[i + 2]));
    }
  }
  CHECK(lines == 3 + 3);
  CHECK(dashed == 1);
  CHECK(plot.x.high < 20.0);
  CHECK(xml_fault(toolchain::render(plot)).empty());
  CHECK(toolchain::plot_fired_rays({}, occupied, {}).series.empty());
  // Rays that all meet nothing have a picture, too.
  for (toolchain::FiredRay& ray : fired.rays) ray.hit = false;
  CHECK(xml_fault(toolchain::render(toolchain::plot_fired_rays(fired, {}, {}))).empty());
}

TEST_CASE(
    "rays of a log are where the robot stood, end at the wall, and the table says what the plans were") {
  const TempFolder folder;
  const std::string log_path = folder.file("standing.lcm");
  SslTraffic traffic;
  traffic.commands.reserve(64);
  traffic.answers.reserve(64);
  firmware::LiveRunOptions options;
  options.scene = standing_scene(folder);
  options.seconds = 3;
  options.virtual_time = true;
  options.record = log_path;
  options.lcm_url = "none";
  const firmware::SimulatorFactory simulator = [&traffic](firmware::Profile&, drivers::ScanSink*) {
    return std::make_unique<SslBench>(traffic);
  };
  const firmware::LiveRunOutcome run = firmware::run_live(standing_vehicles(), simulator, options);
  const firmware::LogFile log(log_path);
  firmware::Trajectory path;
  for (int i = 0; i <= 30; ++i) {
    firmware::TimedPose pose;
    pose.stamp_ns = 100'000'000LL * i;
    pose.p[0] = StandingVehicle::place().p_world_body_m[0];
    pose.p[1] = StandingVehicle::place().p_world_body_m[1];
    path.push_back(pose);
  }
  firmware::Profile profile(run.runtime->profile().canonical(), "log");
  const double mount_x = firmware::read_ssl_mount(profile).place_m[0];
  const toolchain::FiredRays fired = toolchain::fired_rays(log, std::move(profile), path);
  // What the runtime took, and the answer to its last command, which no job saw. Those of no command are left
  // out.
  CHECK(fired.frames == run.results.counters.at("ssl_frames") + 1);
  CHECK(fired.rays.size() + fired.unplaced == 50 * fired.frames);
  CHECK(fired.unplaced == 0);
  std::size_t hits = 0;
  std::uint32_t command = 0;
  for (const toolchain::FiredRay& ray : fired.rays) {
    REQUIRE(ray.command >= command);
    command = ray.command;
    REQUIRE(std::fabs(ray.from_m[0] - path[0].p[0] - mount_x) < 1e-9);
    double length = 0.0;
    for (int a = 0; a < 3; ++a) length += (ray.to_m[a] - ray.from_m[a]) * (ray.to_m[a] - ray.from_m[a]);
    if (ray.hit) {
      ++hits;
      REQUIRE(std::fabs(ray.to_m[0] - ray.from_m[0] - kSslWall_m) < 2e-3);
    } else {
      REQUIRE(std::fabs(std::sqrt(length) - 12.0) < 1e-9);  // occupancy.silent_free_m
    }
  }
  CHECK(hits > 100);

  // The table, from the jobs of a replay.
  toolchain::RayFigures figures;
  firmware::ReplayOptions replaying;
  std::uint64_t spent = 0;
  replaying.on_job = [&](const rt::JobRecord& record, firmware::Runtime& runtime) {
    figures.job(record, runtime);
    const auto& group = runtime.executive().group(record.group);
    for (std::uint32_t i = 0; i < group.tasks.size(); ++i)
      if (std::string(group.tasks[i]->name()) == "ssl")
        spent = std::max<std::uint64_t>(spent, record.units[i]);
  };
  const firmware::ReplayOutcome again = firmware::replay(log, standing_vehicles(), replaying);
  CHECK(again.results.digest == run.results.digest);
  const std::vector<toolchain::FigureRow> rows = figures.rows(0);
  CHECK(value_of(rows, "commands") == "30");
  CHECK(value_of(rows, "late plans, whose command was dropped") == "0");
  CHECK(value_of(rows, "commands without a plan (strides)") == "1");
  CHECK(value_of(rows, "plans") == "29");
  CHECK(value_of(rows, "units that a plan may spend") == firmware::group_digits(400'000));
  CHECK(value_of(rows, "units spent, most") == firmware::group_digits(spent));
  CHECK(spent > 100'000);
  CHECK(value_of(figures.rows(2000), "commands") == "10");
  CHECK(figures.rows(1'000'000).empty());
  CHECK(toolchain::RayFigures().rows(0).empty());

  // Planned faults of the executive show: a job that missed its deadline, one that was cut, one that was left
  // out.
  rt::JobRecord record;
  toolchain::RayFigures wrong;
  const firmware::Runtime& runtime = *again.runtime;
  for (std::uint32_t g = 0; g < runtime.executive().group_count(); ++g) {
    const auto& group = runtime.executive().group(g);
    if (std::string(group.spec.name) == "mapping") record.group = static_cast<std::uint16_t>(g);
  }
  record.units[1] = 1234;  // behind `occupancy`
  record.verdict = rt::Verdict::missed;
  record.cut = 0b10;
  wrong.job(record, runtime);
  record.verdict = rt::Verdict::done;
  record.cut = 0b01;  // of the other task
  record.shed = 0b10;
  wrong.job(record, runtime);
  CHECK(value_of(wrong.rows(0), "commands") == "1");
  CHECK(value_of(wrong.rows(0), "late plans, whose command was dropped") == "1");
  CHECK(value_of(wrong.rows(0), "plans that the clock cut") == "1");
  CHECK(value_of(wrong.rows(0), "releases that the ladder left out") == "1");

  // And a page with it.
  toolchain::ReportInput page;
  page.results.scene = "standing";
  page.tables.push_back({"Solid-state lidar", rows});
  page.tables.push_back({"Nothing", {}});
  const std::string html = toolchain::render_report(page);
  CHECK(mentions(html, "Solid-state lidar"));
  CHECK(mentions(html, "units spent, median"));
  CHECK_FALSE(mentions(html, "Nothing"));
}

}  // namespace sortie::testing
