// SPDX-License-Identifier: BSD-3-Clause
// Where ticks go and how they are labelled.
#include "toolchain/report/svg_path.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {
namespace {

/// 12000 -> "12k", 0.05 -> "0.05", 1e-9 -> "1e-9": short enough for an axis.
std::string tick_label(double value, double step) {
  const double size = std::fabs(value);
  if (size == 0.0) return "0";
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 12);
  if (size >= 1e9 || size < 1e-4) return firmware::format_short(value);
  if (size >= 1e6 && step >= 1e4)
    return firmware::format_fixed(value / 1e6, std::max(0, decimals + 6 - 6 * (step >= 1e6))) + "M";
  if (size >= 1e4 && step >= 1e3) return firmware::format_fixed(value / 1e3, 0) + "k";
  return firmware::format_fixed(value, decimals);
}

std::vector<Tick> linear_ticks(double low, double high, int wanted) {
  const double raw = (high - low) / std::max(1, wanted);
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * decade;
  for (const double nice : {1.0, 2.0, 5.0}) {
    if (nice * decade >= raw * 0.999) {
      step = nice * decade;
      break;
    }
  }
  std::vector<Tick> ticks;
  if (wanted < 20 && std::floor(high / step + 1e-9) - std::ceil(low / step - 1e-9) < 2.0) {
    return linear_ticks(low, high, wanted + 1);  // fewer than three labels do not give a scale
  }
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) {
    ticks.push_back({k * step, tick_label(k * step, step)});
  }
  return ticks;
}

std::vector<Tick> log_ticks(double low, double high, int wanted) {
  const double decades = std::log10(high / low);
  if (decades < 0.5) return linear_ticks(low, high, wanted);
  const int every = std::max(1, static_cast<int>(std::ceil(decades / std::max(2, wanted))));
  std::vector<Tick> ticks;
  const auto label_of = [](double value, int k) { return tick_label(value, std::pow(10.0, k)); };
  std::size_t labels = 0;
  for (int k = static_cast<int>(std::floor(std::log10(low)));
       k <= static_cast<int>(std::ceil(std::log10(high))); ++k) {
    for (int m = 1; m <= 9; ++m) {
      const double value = m * std::pow(10.0, k);
      if (value < low * 0.999999 || value > high * 1.000001) continue;
      const bool labelled = m == 1 ? k % every == 0 : decades < 1.6 && (m == 2 || m == 5);
      if (m > 1 && every > 1) continue;
      ticks.push_back({value, labelled ? label_of(value, k) : std::string()});
      labels += labelled ? 1 : 0;
    }
  }
  if (labels < 2) {  // less than a decade that holds no two of 1, 2, 5: label every tick
    for (Tick& tick : ticks)
      tick.label = label_of(tick.value, static_cast<int>(std::floor(std::log10(tick.value) + 1e-9)));
  }
  return ticks;
}

}  // namespace

double Scale::position(double value) const {
  if (!log) return (value - low) / (high - low);
  return value > 0.0 ? std::log10(value / low) / std::log10(high / low) : std::nan("");
}

Scale make_scale(double low, double high, bool log) {
  if (!(low <= high)) {
    low = log ? 1.0 : 0.0;
    high = log ? 10.0 : 1.0;
  }
  if (log) {
    if (high < low * 1.5) {
      low /= 1.5;
      high *= 1.5;
    }
    return {low, high, true};
  }
  if (high - low < 1e-12 * std::max(1.0, std::fabs(high))) {
    const double room = high == 0.0 ? 1.0 : 0.1 * std::fabs(high);
    return {low - room, high + room, false};
  }
  return {low, high, false};
}

std::vector<Tick> make_ticks(const Scale& scale, int wanted) {
  return scale.log ? log_ticks(scale.low, scale.high, wanted) : linear_ticks(scale.low, scale.high, wanted);
}

}  // namespace sortie::toolchain
