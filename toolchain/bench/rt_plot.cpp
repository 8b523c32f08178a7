// SPDX-License-Identifier: BSD-3-Clause
// A latency plot as OSADL draws them: how often over how late, both logarithmic, so that one outlier in a
// million stands beside the bulk.
#include <algorithm>
#include <cmath>
#include <map>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

constexpr double kWakeBinsPerDecade = 12;
constexpr double kFloorUs = 0.01;  // a log axis has no zero: what was faster counts as this
constexpr double kNothing = 0.7;   // below one sample

double edge(int bin) { return std::pow(10.0, bin / kWakeBinsPerDecade); }
int bin_of(double us) {
  return static_cast<int>(std::floor(std::log10(std::max(us, kFloorUs)) * kWakeBinsPerDecade + 1e-9));
}

// Samples by equal steps of the logarithm; a recorded bin that spans several of them is spread evenly.
std::map<int, double> rebin(const firmware::Json& bins) {
  std::map<int, double> result;
  for (const firmware::Json& bin : bins) {
    if (!bin.is_array() || bin.size() != 3) continue;
    const double low = std::max(bin[0].get<double>(), kFloorUs);
    const double high = std::max(bin[1].get<double>(), low * 1.000001);
    const double count = bin[2].get<double>();
    for (int i = bin_of(low); i <= bin_of(high); ++i) {
      const double share = (std::min(high, edge(i + 1)) - std::max(low, edge(i))) / (high - low);
      if (share > 0) result[i] += share * count;
    }
  }
  return result;
}

}  // namespace

std::vector<BenchPicture> rt_pictures(const firmware::Json& result) {
  Plot plot{"Lateness of wake-ups at 1 kHz",
            {"later than asked, \u00b5s", true},
            {"wake-ups", true, kNothing},
            760,
            380};
  int colour = 0;
  for (const firmware::Json& one : result.value("distributions", firmware::Json::array())) {
    Series series{one.value("name", "") + ", n " + firmware::group_digits(one.value("n", std::uint64_t{0})) +
                      ", max " + firmware::format_short(one.value("max_us", 0.0)) + " \u00b5s",
                  Mark::steps, colour++};
    series.dashed = series.colour != 0;
    const std::map<int, double> bins = rebin(one.value("bins_us", firmware::Json::array()));
    if (bins.empty()) continue;
    for (int i = bins.begin()->first; i <= bins.rbegin()->first; ++i) {
      const auto found = bins.find(i);
      const bool any = found != bins.end() && !(found->second < 0.5);
      series.add(edge(i), any ? std::max(found->second, 1.0) : kNothing);
    }
    series.add(edge(bins.rbegin()->first + 1), kNothing);
    plot.series.push_back(std::move(series));
  }
  if (plot.series.empty()) return {};
  plot.rules.push_back({1000, "deadline: the next release", 6});
  return {{"bench-rt-wake.svg", std::move(plot), "wake-up"}};
}

}  // namespace sortie::toolchain
