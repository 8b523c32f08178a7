// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include "toolchain/bench/ray_bench.hpp"

namespace sortie::toolchain {

namespace {

constexpr double kLeastLoss = 1e-4;  // below this the curve would only stretch the axis

// What a planner leaves on the table over the time that it takes, task by task.
std::vector<RayPicture> plot_tasks(const firmware::Json& curves) {
  std::vector<RayPicture> pictures;
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
      RayPicture& picture = pictures.emplace_back();
      picture.file = "bench-rays-" + std::to_string(++number) + ".svg";
      picture.plot.title = task;
      picture.plot.x = {"run time, ms", true};
      picture.plot.y = {"1 - worth / greedy", true};
      picture.plot.width = 820;
      picture.plot.height = 380;
    }
    const std::string planner = point.value("planner", "");
    const double ms = std::max(point.value("ms", 0.0), 0.01);
    const double loss = std::max(1.0 - point.value("ratio", 0.0), kLeastLoss);
    if (planner.rfind("ours: ", 0) == 0) {
      ours.name = "ours, stage after stage";
      ours.mark = Mark::steps;
      ours.colour = kBlue;
      ours.x.push_back(ms);
      ours.y.push_back(loss);
      continue;
    }
    Series one;
    one.name = planner;
    one.mark = Mark::dots;
    one.colour = 1 + static_cast<int>(pictures.back().plot.series.size());
    one.width = 5;
    one.x = {ms};
    one.y = {loss};
    pictures.back().plot.series.push_back(one);
  }
  flush();
  return pictures;
}

Plot plot_rays(const firmware::Json& picture) {
  Plot plot;
  plot.title = "Chosen rays over the map's entropy, from above";
  plot.x = {"x, m"};
  plot.y = {"y, m"};
  plot.equal_aspect = true;
  plot.width = 820;
  plot.height = 820;
  constexpr double kSteps[] = {0.05, 0.15, 0.25, 0.35};
  Series levels[4];
  for (int i = 0; i < 4; ++i) {
    levels[i].mark = Mark::dots;
    levels[i].colour = kGrey;
    levels[i].width = 0.6 + 0.7 * i;
  }
  levels[3].name = "mean entropy of a column: larger dots for more";
  for (const firmware::Json& block : picture.value("blocks", firmware::Json::array())) {
    const double entropy = block[2].get<double>();
    for (int i = 3; i >= 0; --i) {
      if (entropy < kSteps[i]) continue;
      levels[i].x.push_back(block[0].get<double>());
      levels[i].y.push_back(block[1].get<double>());
      break;
    }
  }
  for (Series& level : levels) plot.series.push_back(level);
  Series rays;
  rays.name = "chosen rays, to where nine of ten end";
  rays.colour = kVermilion;
  rays.width = 0.7;
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const firmware::Json& ray : picture.value("rays", firmware::Json::array())) {
    rays.x.insert(rays.x.end(), {picture["from"][0].get<double>(), ray[0].get<double>(), none});
    rays.y.insert(rays.y.end(), {picture["from"][1].get<double>(), ray[1].get<double>(), none});
  }
  plot.series.push_back(rays);
  return plot;
}

}  // namespace

std::vector<RayPicture> ray_pictures(const firmware::Json& result) {
  std::vector<RayPicture> pictures = plot_tasks(result.value("ray_curves", firmware::Json::array()));
  if (result.contains("ray_picture"))
    pictures.push_back({"bench-rays-picture.svg", plot_rays(result["ray_picture"])});
  return pictures;
}

}  // namespace sortie::toolchain
