// SPDX-License-Identifier: BSD-3-Clause
// Truth is a broad grey line below, the estimate a thin blue one above: apart also on a black and white
// printer.
#include "toolchain/report/plots.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace sortie::toolchain {
namespace {

constexpr double kBinsPerDecade = 20.0;

/// Counts by equal steps of log time: recorded buckets are far finer than a picture shows. A log axis has no
/// zero, so what was faster than 10 ns counts as 10 ns.
std::map<int, std::uint64_t> rebin(const std::vector<firmware::HistogramBar>& bars) {
  std::map<int, std::uint64_t> bins;
  for (const firmware::HistogramBar& bar : bars) {
    const double centre = 0.5 * (bar.from_us + bar.to_us);
    const double middle = centre > 0.01 ? std::min(centre, 1e12) : 0.01;  // also for a NaN
    if (bar.count > 0) bins[static_cast<int>(std::floor(std::log10(middle) * kBinsPerDecade))] += bar.count;
  }
  return bins;
}

Series truth_series() { return {"truth", Mark::line, kGrey, 4.0}; }

Series estimate_series(bool is_located) {
  return {is_located ? "odometry" : "estimate", Mark::line, kBlue, 1.6};
}

Series located_series() { return {"located", Mark::line, kVermilion, 1.6}; }

Series marker(const char* name, const firmware::TimedPose& pose, int colour) {
  return {name, Mark::dots, colour, 3.0, false, {pose.p[0]}, {pose.p[1]}};
}

bool has(const firmware::TimedPose& pose, std::uint32_t flags) { return (pose.flags & flags) == flags; }

/// Seen along the world's y axis.
void add_side_view(std::span<const firmware::TimedPose> poses, Series& series) {
  for (const firmware::TimedPose& pose : poses) {
    const bool shown = has(pose, rt::kTruthPosition | rt::kTruthHeight);
    series.add(shown ? pose.p[0] : std::nan(""), shown ? pose.p[2] : std::nan(""));
  }
}

}  // namespace

Plot plot_latency(const firmware::TaskResult& task) {
  Plot plot{task.name, {"execution time, \u00b5s", true}, {"jobs", true, 0.7}, 480, 250};
  Series bars{"", Mark::bars};
  for (const auto& [bin, count] : rebin(task.histogram)) {
    bars.add(std::pow(10.0, bin / kBinsPerDecade), static_cast<double>(count));
    bars.x_end.push_back(std::pow(10.0, (bin + 1) / kBinsPerDecade));
  }
  plot.series.push_back(std::move(bars));
  if (task.budget_us > 0.0) plot.rules.push_back({task.budget_us, "budget", kVermilion});
  if (task.period_us > 0.0 && task.period_us < 1e3 * std::max(task.max_us, 1.0)) {
    plot.rules.push_back({task.period_us, "period", kBlack});
  }
  return plot;
}

Plot plot_top(const RunPaths& paths) {
  Plot plot{"From above", {"x, m"}, {"y, m"}, 640, 470, true};
  Series reference = truth_series();
  for (const firmware::TimedPose& pose : paths.truth) {
    const bool shown = has(pose, rt::kTruthPosition);
    reference.add(shown ? pose.p[0] : std::nan(""), shown ? pose.p[1] : std::nan(""));
  }
  if (!paths.truth.empty()) plot.series.push_back(std::move(reference));
  const auto add = [&plot](Series series, std::span<const firmware::TimedPose> path) {
    for (const firmware::TimedPose& pose : path) series.add(pose.p[0], pose.p[1]);
    plot.series.push_back(std::move(series));
  };
  const bool is_located = !paths.located.empty();
  if (!paths.estimate.empty() || !is_located) add(estimate_series(is_located), paths.estimate);
  if (is_located) add(located_series(), paths.located);
  const auto& marked = is_located ? paths.located : paths.estimate;
  if (!marked.empty()) {
    plot.series.push_back(marker("start", marked.front(), kGreen));
    plot.series.push_back(marker("end", marked.back(), kVermilion));
  }
  return plot;
}

Plot plot_side(const RunPaths& paths) {
  Plot plot{"From the side", {"x, m"}, {"z, m"}, 640, 240};
  const bool has_height = std::any_of(
      paths.truth.begin(), paths.truth.end(),
      [](const firmware::TimedPose& pose) { return has(pose, rt::kTruthPosition | rt::kTruthHeight); });
  if (has_height) {
    plot.series.push_back(truth_series());
    add_side_view(paths.truth, plot.series.back());
  }
  const bool is_located = !paths.located.empty();
  if (!paths.estimate.empty() || !is_located) {
    plot.series.push_back(estimate_series(is_located));
    add_side_view(paths.estimate, plot.series.back());
  }
  if (is_located) {
    plot.series.push_back(located_series());
    add_side_view(paths.located, plot.series.back());
  }
  Extent x;
  Extent z;
  for (const Series& s : plot.series) {
    x.take(s.x);
    z.take(s.y);
  }
  if (z.size() > 0.1 * x.size()) {
    plot.equal_aspect = true;
    plot.height = z.size() > 0.4 * x.size() ? 330 : 240;
  } else {
    plot.y.label = "z, m (stretched)";
    if (z.size() < 0.2) {  // a flat floor shall look flat
      plot.y.low = 0.5 * (z.low + z.high) - 0.1;
      plot.y.high = 0.5 * (z.low + z.high) + 0.1;
    }
  }
  return plot;
}

Plot plot_position_error(std::span<const ErrorSample> errors) {
  Plot plot{"Position error", {"time, s"}, {"error, m", false, 0.0}, 640, 230};
  Series s;
  for (const ErrorSample& e : errors) s.add(e.time_s, e.position_m);
  plot.series.push_back(std::move(s));
  return plot;
}

Plot plot_orientation_error(std::span<const ErrorSample> errors) {
  Plot plot{"Orientation error", {"time, s"}, {"error, degrees"}, 640, 230};
  Series inclination{"inclination"};
  Series heading{"heading (from the first truth on)", Mark::line, kVermilion};
  for (const ErrorSample& e : errors) {
    inclination.add(e.time_s, e.inclination_deg);
    heading.add(e.time_s, e.heading_deg);
  }
  plot.series.push_back(std::move(heading));
  plot.series.push_back(std::move(inclination));
  return plot;
}

}  // namespace sortie::toolchain
