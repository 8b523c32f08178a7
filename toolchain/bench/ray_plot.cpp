// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

constexpr double kLeastLoss = 1e-4;  // below this the curve would only stretch the axis

// What a planner leaves on the table over the time that it takes, task by task.
std::vector<BenchPicture> plot_tasks(const firmware::Json& curves) {
  std::vector<BenchPicture> pictures;
  std::string task;
  Series ours;
  int number = 0;
  const auto flush = [&] {
    if (!pictures.empty() && !ours.x.empty()) pictures.back().plot.series.push_back(ours);
    ours = {};
  };
  for (const firmware::Json& point : curves) {
    if (point.value("task", "") != task) {
      flush();
      task = point.value("task", "");
      pictures.push_back({"bench-rays-" + std::to_string(++number) + ".svg",
                          {task, {"run time, ms", true}, {"1 - worth / greedy", true}, 820, 380},
                          ""});
    }
    const std::string planner = point.value("planner", "");
    const double ms = std::max(point.value("ms", 0.0), 0.01);
    const double loss = std::max(1.0 - point.value("ratio", 0.0), kLeastLoss);
    if (planner.rfind("ours: ", 0) == 0) {
      ours.name = "ours, stage after stage";
      ours.mark = Mark::steps;
      ours.colour = kBlue;
      ours.add(ms, loss);
      continue;
    }
    std::vector<Series>& series = pictures.back().plot.series;
    series.push_back({planner, Mark::dots, 1 + static_cast<int>(series.size()), 5, false, {ms}, {loss}});
  }
  flush();
  return pictures;
}

Plot plot_rays(const firmware::Json& picture) {
  Plot plot{"Chosen rays over the map's entropy, from above", {"x, m"}, {"y, m"}, 820, 820, true};
  constexpr double kSteps[] = {0.05, 0.15, 0.25, 0.35};
  Series levels[4];
  for (int i = 0; i < 4; ++i) levels[i] = {"", Mark::dots, kGrey, 0.6 + 0.7 * i};
  levels[3].name = "mean entropy of a column: larger dots for more";
  for (const firmware::Json& block : picture.value("blocks", firmware::Json::array())) {
    const double entropy = block[2].get<double>();
    for (int i = 3; i >= 0; --i) {
      if (entropy < kSteps[i]) continue;
      levels[i].add(block[0].get<double>(), block[1].get<double>());
      break;
    }
  }
  for (Series& level : levels) plot.series.push_back(level);
  Series rays{"chosen rays, to where nine of ten end", Mark::line, kVermilion, 0.7};
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const firmware::Json& ray : picture.value("rays", firmware::Json::array())) {
    rays.x.insert(rays.x.end(), {picture["from"][0].get<double>(), ray[0].get<double>(), none});
    rays.y.insert(rays.y.end(), {picture["from"][1].get<double>(), ray[1].get<double>(), none});
  }
  plot.series.push_back(rays);
  return plot;
}

}  // namespace

std::vector<BenchPicture> ray_pictures(const firmware::Json& result) {
  std::vector<BenchPicture> pictures = plot_tasks(result.value("ray_curves", firmware::Json::array()));
  if (result.contains("ray_picture"))
    pictures.push_back({"bench-rays-picture.svg", plot_rays(result["ray_picture"]), ""});
  return pictures;
}

}  // namespace sortie::toolchain
