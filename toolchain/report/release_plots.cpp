// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/report/release_plots.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {
namespace {

constexpr double kFloor = 0.5;  // where a logarithmic count of none is drawn
constexpr double kLateBinsPerDecade = 40.0;
constexpr double kLeastView = 20.0;
constexpr double kMostBins = 20'000.0;

/// "82.4 us", "1.8 ms".
std::string duration_text(double us) {
  return us >= 1e6   ? firmware::format_short(us * 1e-6) + " s"
         : us >= 1e3 ? firmware::format_short(us * 1e-3) + " ms"
                     : firmware::format_short(us) + " \u00b5s";
}

/// The exact maximum where it is known, else the upper edge of the last bucket.
double end_of(std::span<const firmware::HistogramBar> bars, double known_max) {
  const double edge = bars.empty() ? 0 : bars.back().to_us;
  return known_max > 0 ? std::min(edge, known_max) : edge;
}
double latest(const firmware::GroupResult& group) { return end_of(group.lateness, group.late_max_us); }

/// Where the axis of microseconds ends.
double view_of(std::span<const firmware::GroupResult> groups) {
  double most = 0;
  double deadline = kMostBins;
  for (const firmware::GroupResult& group : groups) {
    if (group.lateness.empty()) continue;
    most = std::max(most, latest(group));
    if (group.deadline_us > 0) deadline = std::min(deadline, group.deadline_us);
  }
  return std::max(kLeastView, std::min(1.04 * most, std::min(1.2 * deadline, kMostBins)));
}

/// Counts by whole microseconds; a bucket that is wider fills each of its bins.
Series bins_of(const firmware::GroupResult& group, double view, int colour) {
  std::map<long, std::uint64_t> count;
  for (const firmware::HistogramBar& bar : group.lateness) {
    if (!(bar.from_us < view) || bar.count == 0) continue;
    const long first = static_cast<long>(bar.from_us);
    const long last = bar.to_us - bar.from_us <= 1.0 ? first : static_cast<long>(std::min(bar.to_us, view));
    for (long bin = first; bin <= last; ++bin) count[bin] += bar.count;
  }
  Series series{"", Mark::steps, colour, 1.3};
  long next = -1;
  for (const auto& [bin, n] : count) {
    if (bin != next) {  // down to the floor, and up again
      if (next >= 0) series.add(static_cast<double>(next), kFloor);
      series.add(static_cast<double>(bin), kFloor);
    }
    series.add(static_cast<double>(bin), static_cast<double>(n));
    next = bin + 1;
  }
  if (next >= 0) series.add(static_cast<double>(next), kFloor);
  return series;
}

/// Deadlines that fall on one place share a line.
void add_deadlines(std::span<const firmware::GroupResult> groups, double view, Plot& plot) {
  std::map<double, std::string> names;
  for (const firmware::GroupResult& group : groups) {
    if (group.deadline_us <= 0 || group.deadline_us > view) continue;
    std::string& name = names[group.deadline_us];
    name += (name.empty() ? "deadline " : ", ") + group.name;
  }
  for (const auto& [deadline, name] : names) plot.rules.push_back({deadline, name, 1});
}

/// Vermilion is the deadlines'.
int colour_of(std::size_t index) {
  constexpr int kLines[] = {0, 2, 3, 4, 5, 6, 7};
  return kLines[index % std::size(kLines)];
}

}  // namespace

bool has_releases(std::span<const firmware::GroupResult> groups) {
  return std::any_of(groups.begin(), groups.end(),
                     [](const firmware::GroupResult& group) { return !group.lateness.empty(); });
}

Plot plot_wake_up(std::span<const firmware::GroupResult> groups) {
  const double view = view_of(groups);
  Plot plot{"Wake-up latency",
            {"begin of the job after its release, \u00b5s", false, 0.0, view},
            {"releases in 1 \u00b5s", true, kFloor},
            960,
            330};
  double edge = 1.0;  // the height of what lies beyond the view: one above the other
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const firmware::GroupResult& group = groups[i];
    if (group.lateness.empty()) continue;
    const double most = latest(group);
    Series line = bins_of(group, view, colour_of(i));
    line.name = group.name + ": max " + duration_text(most) + (most > view ? " \u2192" : "");
    plot.series.push_back(std::move(line));
    Series marker{"", Mark::dots, colour_of(i), 2.6};
    marker.add(std::min(most, 0.994 * view),
               most > view ? edge : static_cast<double>(group.lateness.back().count));
    if (most > view) edge *= 4.0;
    marker.labels = {most > view ? "max \u2192" : "max"};
    plot.series.push_back(std::move(marker));
  }
  add_deadlines(groups, view, plot);
  return plot;
}

Plot plot_response(std::span<const firmware::GroupResult> groups) {
  Plot plot{"Response against the deadline",
            {"end of the job after its release, \u00b5s", true},
            {"jobs", true, kFloor},
            960,
            330};
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const firmware::GroupResult& group = groups[i];
    if (group.response.empty()) continue;
    std::map<int, std::uint64_t> count;
    for (const firmware::HistogramBar& bar : group.response) {
      const double middle = std::max(0.5 * (bar.from_us + bar.to_us), 0.01);
      count[static_cast<int>(std::floor(std::log10(middle) * kLateBinsPerDecade))] += bar.count;
    }
    Series line{"", Mark::steps, colour_of(i), 1.3};
    const auto edge = [](int bin) { return std::pow(10.0, bin / kLateBinsPerDecade); };
    for (int bin = count.begin()->first; bin <= count.rbegin()->first + 1; ++bin) {
      const auto found = count.find(bin);
      if (bin == count.begin()->first) line.add(edge(bin), kFloor);
      line.add(edge(bin), found == count.end() ? kFloor : static_cast<double>(found->second));
    }
    line.name = group.name + ": max " + duration_text(end_of(group.response, group.response_max_us)) +
                " of " + duration_text(group.deadline_us);
    plot.series.push_back(std::move(line));
  }
  add_deadlines(groups, 1e12, plot);
  return plot;
}

std::string render_latency_file(std::span<const firmware::GroupResult> groups, const std::string& title) {
  const Plot plots[] = {plot_wake_up(groups), plot_response(groups)};
  constexpr double kHead = 30.0;
  double height = kHead;
  std::string body;
  for (const Plot& plot : plots) {
    body +=
        "<g transform=\"translate(0 " + firmware::format_fixed(height, 0) + ")\">" + render(plot) + "</g>\n";
    height += plot.height + 10.0;
  }
  const std::string size = "\" width=\"960\" height=\"" + firmware::format_fixed(height, 0) + "\"";
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 960 " + firmware::format_fixed(height, 0) +
         size +
         " font-family=\"system-ui, 'DejaVu Sans', Arial, sans-serif\">\n<rect width=\"960\" height=\"" +
         firmware::format_fixed(height, 0) +
         "\" fill=\"#fff\"/>\n<text x=\"60\" y=\"22\" font-size=\"13\" fill=\"#5b646d\">" +
         escape_xml(title) + "</text>\n" + body + "</svg>\n";
}

}  // namespace sortie::toolchain
