// SPDX-License-Identifier: BSD-3-Clause
// Plots and the report page: well-formed, bounded, true to their data, and safe against whatever names hold.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/firmware_like/temp_folder.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/plots.hpp"
#include "toolchain/report/svg_path.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using sortie::testing::xml_fault;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + part.size())) ++n;
  return n;
}

std::vector<std::string> labels(const Scale& scale, int wanted) {
  std::vector<std::string> texts;
  for (const toolchain::Tick& tick : make_ticks(scale, wanted)) {
    if (!tick.label.empty()) texts.push_back(tick.label);
  }
  return texts;
}

Trajectory circle(int n, double radius, std::uint32_t flags) {
  Trajectory t;
  for (int i = 0; i < n; ++i) {
    TimedPose p;
    p.stamp_ns = std::int64_t{10'000'000} * i;
    p.p[0] = radius * std::cos(0.01 * i);
    p.p[1] = radius * std::sin(0.01 * i);
    p.p[2] = 0.001 * i;
    p.flags = flags;
    t.push_back(p);
  }
  return t;
}

ReportInput example_report() {
  ReportInput in;
  Results& r = in.results;
  r.digest = "9f86d081884c7d65";
  r.ticks = 199900;
  r.scene = "skid_outdoor";
  r.vehicle = "ugv";
  r.errors = {{"ate_rmse_m", 3.2176}};
  r.tasks = {{"attitude",
              "imu",
              1000,
              50,
              199900,
              2,
              0.12,
              1.3,
              2.5,
              22.8,
              "ab",
              {{0.1, 0.2, 199000}, {0.2, 30.0, 900}}}};
  r.pools = {{"voxels", 262144, 262144, 45428, 1u << 24}};
  r.counters = {{"track_gaps", 12}};
  r.machine = "a machine";
  r.compiler = "a compiler";
  r.warnings = {"not real-time"};
  in.command = "sortie replay a.lcm";
  in.alignment = "se2";
  in.estimate = circle(700, 5.0, rt::kTruthPosition | rt::kTruthHeight);
  in.truth = circle(700, 5.1, rt::kTruthPosition | rt::kTruthHeight);
  for (int i = 0; i < 700; ++i) in.errors.push_back({0.01 * i, 0.1, 0.2, -0.3});
  return in;
}

}  // namespace

TEST_CASE("the XML check finds what is not well-formed") {
  CHECK(xml_fault("<a><b x=\"1\"/>t &amp; &#39;</a>").empty());
  for (const char* bad :
       {"", "text", "<a>", "<a></b>", "<a><b></a></b>", "<a x=1/>", "<a x=\"1\" x=\"2\"/>", "<a>&</a>",
        "<a>&foo;</a>", "<a/><b/>", "<a x=\"<\"/>", "<a b=\"1\"c=\"2\"/>", "<a>\x01</a>", "<a", "<>"}) {
    INFO(bad);
    CHECK_FALSE(xml_fault(bad).empty());
  }
}

TEST_CASE("ticks stand at round values and there are always enough of them to read a scale") {
  CHECK(labels(make_scale(0, 10, false), 5) == std::vector<std::string>{"0", "2", "4", "6", "8", "10"});
  CHECK(labels(make_scale(-0.3, 0.3, false), 3).size() >= 3);
  CHECK(labels(make_scale(0.1, 10000, true), 6) ==
        std::vector<std::string>{"0.1", "1", "10", "100", "1000", "10k"});
  CHECK(labels(make_scale(2, 7, true), 6).size() >= 2);    // less than a decade
  CHECK(labels(make_scale(12, 14, true), 6).size() >= 2);  // hardly any
  CHECK(labels(make_scale(1e-9, 1e9, true), 6).size() <= 10);
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const double a = std::pow(10.0, static_cast<double>(random() % 24) - 12.0) *
                     (1.0 + static_cast<double>(random() % 1000));
    const double b = a * (1.0 + static_cast<double>(random() % 1000) / 100.0) + 1e-9 * a;
    const bool log = random() % 2 == 0;
    const auto ticks = make_ticks(make_scale(a, b, log), 5);
    INFO(a << " to " << b << (log ? " log" : " linear"));
    CHECK(ticks.size() <= 60);
    CHECK(labels(make_scale(a, b, log), 5).size() >= 2);
  }
}

TEST_CASE("scales are never empty") {
  for (const bool log : {false, true}) {
    for (const double value : {1.0, 1e-9, 1e9}) {
      const Scale s = make_scale(value, value, log);
      CHECK(s.low < s.high);
      CHECK(std::isfinite(s.position(value)));
    }
  }
  CHECK(make_scale(1, 0, false).low < make_scale(1, 0, false).high);
  CHECK(std::isnan(make_scale(1, 10, true).position(0.0)));
}

TEST_CASE("a line of a million points is as small as the picture, and keeps its extremes") {
  Plot plot;
  plot.width = 400;
  plot.height = 300;
  Series s;
  for (int i = 0; i < 1'000'000; ++i) {
    s.x.push_back(i);
    s.y.push_back(i == 654'321 ? 50.0 : std::sin(0.001 * i));
  }
  plot.series = {s};
  const std::string svg = render(plot);
  CHECK(xml_fault(svg).empty());
  CHECK(svg.size() < 40'000);
  const Mapping map{make_scale(0, 999'999, false), make_scale(-1, 50, false), {0, 0, 326, 200}};
  CHECK(draw_series(s, map).find(" 0.0L") != std::string::npos);  // the peak touches the top
}

TEST_CASE("NaNs break lines, and nothing that is not finite reaches the file") {
  Plot plot;
  Series s;
  const double nan = std::nan("");
  s.x = {0, 1, 2, 3, 4, HUGE_VAL, 6};
  s.y = {0, 1, nan, 3, 2, 1, HUGE_VAL};
  for (const Mark mark : {Mark::line, Mark::steps, Mark::dots, Mark::bars}) {
    s.mark = mark;
    s.x_end = {1, 2, 3, 4, 5, 6, 7};
    plot.series = {s};
    plot.rules = {{nan, "never", 1}, {2.0, "here", 1}};
    for (const bool log : {false, true}) {
      plot.x.log = plot.y.log = log;
      const std::string svg = render(plot);
      CHECK(xml_fault(svg).empty());
      CHECK(svg.find("nan") == std::string::npos);
      CHECK(svg.find("inf") == std::string::npos);
      CHECK(svg.find("never") == std::string::npos);
    }
  }
  s.mark = Mark::line;
  const Mapping map{make_scale(0, 10, false), make_scale(0, 10, false), {0, 0, 100, 100}};
  CHECK(count(draw_series(s, map), "M") == 2);
}

TEST_CASE("equal aspect makes a metre as long both ways") {
  Plot plot;
  plot.equal_aspect = true;
  plot.width = 600;
  plot.height = 400;
  Series s;
  s.mark = Mark::bars;
  s.x = {0.0};
  s.x_end = {10.0};
  s.y = {10.0};
  Series origin;
  origin.x = {0.0};
  origin.y = {0.0};
  plot.series = {s, origin};
  // The side of a square, drawn as a bar from y 0 would need the scale itself: take two dots instead.
  Series dots;
  dots.mark = Mark::dots;
  dots.x = {0.0, 10.0, 10.0};
  dots.y = {0.0, 0.0, 10.0};
  plot.series = {dots};
  const std::string svg = render(plot);
  std::vector<double> cx;
  std::vector<double> cy;
  for (std::size_t i = svg.find("cx=\""); i != std::string::npos; i = svg.find("cx=\"", i + 4)) {
    cx.push_back(std::stod(svg.substr(i + 4)));
    cy.push_back(std::stod(svg.substr(svg.find("cy=\"", i) + 4)));
  }
  REQUIRE(cx.size() == 3);
  CHECK(cx[1] - cx[0] == Approx(cy[1] - cy[2]).margin(0.2));
}

TEST_CASE("a plot without data says so") {
  const std::string svg = render(Plot{});
  CHECK(xml_fault(svg).empty());
  CHECK(svg.find("no data") != std::string::npos);
}

TEST_CASE("latency bars keep every job of the finer histogram") {
  TaskResult task;
  task.name = "t";
  std::uint64_t jobs = 0;
  std::mt19937 random(2);
  for (int ns = 0; ns < 100'000; ns += 1 + ns / 64) {
    const std::uint64_t n = random() % 50;
    task.histogram.push_back({1e-3 * ns, 1e-3 * (ns + ns / 64), n});
    jobs += n;
  }
  task.histogram.push_back({std::nan(""), 1.0, 3});
  jobs += 3;
  task.max_us = 100;
  const Plot plot = plot_latency(task);
  double drawn = 0.0;
  for (const double y : plot.series.at(0).y) drawn += y;
  CHECK(drawn == static_cast<double>(jobs));
  CHECK(plot.series[0].x.size() < 110);
  CHECK(xml_fault(render(plot)).empty());
}

TEST_CASE("the report is one well-formed page without script or network") {
  const std::string page = render_report(example_report());
  CHECK(xml_fault(page) == "");
  CHECK(page.find("<script") == std::string::npos);
  CHECK(count(page, "http") == count(page, "http://www.w3.org/"));  // name spaces only
  CHECK(page.find("url(") == std::string::npos);
  for (const char* part : {"skid_outdoor", "9f86d081884c7d65", "ate rmse", "attitude", "45,428", "track_gaps",
                           "a machine", "a compiler", "not real-time", "From above", "From the side",
                           "Position error", "Orientation error", "budget", "se2"}) {
    INFO(part);
    CHECK(page.find(part) != std::string::npos);
  }
  CHECK(page.size() < 200'000);
}

TEST_CASE("names cannot break out of the page") {
  ReportInput in = example_report();
  const std::string evil = "</style><script>alert('1')</script>&\"<\x01>";
  in.results.scene = in.results.vehicle = in.command = in.source = in.alignment = evil;
  in.results.machine = in.results.compiler = in.results.digest = evil;
  in.results.tasks[0].name = in.results.tasks[0].group = in.results.pools[0].name = evil;
  in.results.counters = {{evil, 3}};
  in.results.errors = {{evil, 1.0}};
  in.results.warnings = {evil};
  const std::string page = render_report(in);
  CHECK(xml_fault(page) == "");
  CHECK(page.find("<script") == std::string::npos);
}

TEST_CASE("a report of an attitude shows its error but no path") {
  ReportInput in = example_report();
  for (TimedPose& pose : in.estimate) pose.flags = rt::kTruthOrientation;
  for (ErrorSample& error : in.errors) error.position_m = std::nan("");
  const std::string page = render_report(in);
  CHECK(page.find("From above") == std::string::npos);
  CHECK(page.find("Position error") == std::string::npos);
  CHECK(page.find("Orientation error") != std::string::npos);
}

TEST_CASE("a report of almost nothing is still a page") {
  CHECK(xml_fault(render_report(ReportInput{})) == "");
  ReportInput in;
  in.results.errors["ate_rmse_m"] = std::nan("");
  in.results.tasks.push_back({});
  in.results.pools.push_back({});
  in.estimate = circle(1, 1, 0);
  CHECK(xml_fault(render_report(in)) == "");
  const sortie::testing::TempFolder folder;
  write_file(folder.file("report.html"), render_report(in));
  CHECK(sortie::testing::read_all(folder.file("report.html")) == render_report(in));
}

TEST_CASE("the path on the robot's own map is a third line, and stands alone where there is no odometry") {
  ReportInput in = example_report();
  CHECK(render_report(in).find(">located<") == std::string::npos);
  in.located = circle(700, 5.05, rt::kTruthPosition | rt::kTruthHeight);
  const std::string page = render_report(in);
  CHECK(xml_fault(page) == "");
  for (const char* name : {">truth<", ">odometry<", ">located<"}) {
    INFO(name);
    CHECK(count(page, name) == 2);  // from above and from the side
  }
  in.estimate.clear();
  const std::string alone = render_report(in);
  CHECK(count(alone, ">located<") == 2);
  CHECK(count(alone, ">odometry<") == 0);
  CHECK(count(alone, ">estimate<") == 0);
  CHECK(plot_top({{}, in.truth, in.located}).series.size() == 4);  // two paths, start, end
}
