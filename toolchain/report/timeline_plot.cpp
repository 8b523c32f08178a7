// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>

#include "estimators/obstacle_modes.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/plots.hpp"

namespace sortie::toolchain {
namespace {

struct ModeLook {
  estimators::ObstacleMode mode;
  const char* name;
  int colour;
};
// Planar is what is left white.
constexpr std::array<ModeLook, 5> kModes{{{estimators::ObstacleMode::low_rear, "nose up", 4},
                                          {estimators::ObstacleMode::edge_pivot, "on an edge", 1},
                                          {estimators::ObstacleMode::low_front, "tail down", 3},
                                          {estimators::ObstacleMode::stationary, "standing", 7},
                                          {estimators::ObstacleMode::airborne, "airborne", 6}}};
constexpr int kGroupColours[] = {0, 2, 5, 6};

}  // namespace

Plot plot_timeline(const JobTimeline& timeline) {
  Plot plot{"Longest job of each group over time", {"time, s"}, {"run time, us", true}, 980, 300};
  const std::vector<ModeChange>& changes = timeline.modes();
  for (const ModeLook& look : kModes) {
    Series bands{"", Mark::bands, look.colour};
    double sum_s = 0.0;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      if (changes[i].mode != static_cast<std::uint32_t>(look.mode)) continue;
      const double end_s = i + 1 < changes.size() ? changes[i + 1].time_s : timeline.end_s();
      bands.x.push_back(changes[i].time_s);
      bands.x_end.push_back(end_s);
      sum_s += end_s - changes[i].time_s;
    }
    if (bands.x.empty()) continue;
    bands.name = std::string(look.name) + " " + firmware::format_short(sum_s) + " s";
    plot.series.push_back(std::move(bands));
  }
  std::size_t number = 0;
  for (const GroupTimeline& group : timeline.groups()) {
    Series series{"group " + group.name, Mark::steps, kGroupColours[number++ % std::size(kGroupColours)]};
    double last_s = 0.0;
    for (const SpanMaxima::Span& span : group.job_us.spans()) {
      if (span.from_s > last_s + 1e-9) series.add(last_s, std::nan(""));  // no job: no line
      series.add(span.from_s, span.most);
      last_s = span.to_s;
    }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace sortie::toolchain
