// SPDX-License-Identifier: BSD-3-Clause
// Lateness counted from jobs, and its plots: one bin a microsecond, nothing lost, deadline and maximum shown.
#include "toolchain/report/release_plots.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "firmware_like/log/releases.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/report/html.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using sortie::testing::xml_fault;

namespace {

GroupResult group_of(const std::string& name, double deadline_us, const rt::LatencyHistogram& lateness) {
  GroupResult group;
  group.name = name;
  group.period_us = deadline_us;
  group.deadline_us = deadline_us;
  group.lateness = bars_of(lateness);
  group.late_max_us = static_cast<double>(lateness.max()) * 1e-3;
  group.response_max_us = group.late_max_us;
  group.response = group.lateness;
  return group;
}

// Height of the first line series at x, as steps are read.
double height_at(const Plot& plot, double x) {
  const Series& series = plot.series.front();
  double y = 0;
  for (std::size_t i = 0; i < series.x.size() && series.x[i] <= x; ++i) y = series.y[i];
  return y;
}

}  // namespace

TEST_CASE("releases that were left out count as late until the next job began") {
  ReleaseCounter counter({"fast", 1'000'000, 0, 10, 10, false, 0});
  counter.job(0, 5'000, 105'000, false);
  counter.job(10, 10'000'000, 10'200'000, true);
  counter.job(40, 40'300'000, 40'400'000, false);  // 20 and 30 are missing
  const GroupResult result = counter.result();
  CHECK(result.jobs == 3);
  CHECK(result.missed == 1);
  CHECK(result.skipped == 2);
  std::uint64_t releases = 0;
  for (const HistogramBar& bar : result.lateness) releases += bar.count;
  CHECK(releases == 5);
  CHECK(result.late_max_us == 20'300);
  CHECK(result.response_max_us == 20'400);
  CHECK(result.period_us == 10'000);
}

TEST_CASE("releases before the first job count if the jobs begin with the run") {
  ReleaseCounter counter({"late starter", 1'000'000, 0, 10, 10, true, 3});
  counter.job(23, 23'500'000, 23'600'000, false);  // 3 and 13 are missing
  CHECK(counter.result().skipped == 2);
  CHECK(counter.result().late_max_us == 20'500);
}

TEST_CASE("a nonsense tick does not cost hours") {
  ReleaseCounter counter({"fast", 1'000'000, 0, 1, 1, false, 0});
  counter.job(0, 0, 0, false);
  counter.job(~rt::Tick{0} / 4, 0, 0, false);
  CHECK(counter.result().skipped == 0);
}

TEST_CASE("the wake-up plot counts every microsecond as a plain count does") {
  std::mt19937 random(3);
  rt::LatencyHistogram histogram;
  std::vector<std::uint64_t> twin(60);
  for (int i = 0; i < 100'000; ++i) {
    const auto ns =
        static_cast<std::uint64_t>(random() % 30'000 + (random() % 100 == 0 ? random() % 25'000 : 0));
    histogram.record(ns);
    ++twin[static_cast<std::size_t>(ns / 1000)];
  }
  const Plot plot = plot_wake_up(std::vector<GroupResult>{group_of("fast", 1000, histogram)});
  for (std::size_t bin = 0; bin < twin.size(); ++bin) {
    INFO(bin << " us");
    const double drawn = height_at(plot, static_cast<double>(bin) + 0.5);
    const auto counted = static_cast<double>(twin[bin]);
    // A bucket may reach over the edge of a microsecond: at most 1.6 % of its value is on the other side.
    CHECK(drawn == Approx(counted < 1 ? 0.5 : counted).epsilon(0.5).margin(2));
  }
  double sum = 0;
  for (std::size_t bin = 0; bin < twin.size(); ++bin)
    sum += std::floor(height_at(plot, static_cast<double>(bin) + 0.5));
  CHECK(sum == Approx(100'000).epsilon(0.001));
}

TEST_CASE("an outlier beyond the view is told with its value and the deadline is a line") {
  rt::LatencyHistogram histogram;
  for (int i = 0; i < 1'000'000; ++i) histogram.record(static_cast<std::uint64_t>(1'000 + i % 40'000));
  histogram.record(7'800'000);
  const std::vector<GroupResult> groups{group_of("fast", 50, histogram), group_of("slow", 10'000, histogram)};
  const Plot wake = plot_wake_up(groups);
  CHECK(wake.x.high == 60);
  CHECK(wake.y.log);
  REQUIRE(wake.series.size() == 4);
  CHECK(wake.series[0].name.find("max 7.80 ms \u2192") != std::string::npos);
  CHECK(wake.series[1].labels.front() == "max \u2192");
  REQUIRE(wake.rules.size() == 1);
  CHECK(wake.rules[0].value == 50);
  const Plot response = plot_response(groups);
  CHECK(response.x.log);
  CHECK(response.rules.size() == 2);
  CHECK(response.series[1].name.find("of 10 ms") != std::string::npos);
  CHECK(xml_fault(render_latency_file(groups, "a <title> & more")).empty());
}

TEST_CASE("without measured releases nothing is drawn and nothing breaks") {
  CHECK_FALSE(has_releases({}));
  const std::vector<GroupResult> none(2);
  CHECK_FALSE(has_releases(none));
  CHECK(xml_fault(render_latency_file(none, "")).empty());
  ReportInput input;
  input.results.groups = none;
  CHECK(render_report(input).find("Releases") == std::string::npos);
}

TEST_CASE("the page shows releases and the board's findings safely") {
  rt::LatencyHistogram histogram;
  histogram.record(300);
  histogram.record(2'000'000);
  ReportInput input;
  input.results.groups = {group_of("<fast>", 1000, histogram)};
  input.results.doctor.present = true;
  input.results.doctor.machine = "a & b";
  input.results.doctor.findings = {{"fine", "<good>", Health::good, "why", ""},
                                   {"ill", "x", Health::bad, "because", "echo \"1\" > /sys/<x>"}};
  const std::string page = render_report(input);
  CHECK(xml_fault(page).empty());
  CHECK(page.find("<h2>Releases</h2>") != std::string::npos);
  CHECK(page.find("<h2>Board</h2>") != std::string::npos);
  CHECK(page.find("echo &quot;1&quot; &gt; /sys/&lt;x&gt;") != std::string::npos);
  CHECK(page.find(">ill<") < page.find(">fine<"));
  CHECK(page.find("because") != std::string::npos);
  input.results.doctor.findings.clear();
  input.results.doctor.note = "not recorded";
  CHECK(render_report(input).find("not recorded") != std::string::npos);
}
