// SPDX-License-Identifier: BSD-3-Clause
// Paths bounded by the size of the picture.
#include "toolchain/report/svg_path.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {
namespace {

struct Point {
  double x;
  double y;
};

std::string clamped_number(double value) { return firmware::format_fixed(std::clamp(value, -1e5, 1e5), 1); }

/// Collects a run of points without gaps into path text.
class Path {
 public:
  Path(bool columns, bool steps) : columns_(columns), steps_(steps) {}

  void add(const Point& p) {
    if (columns_) {
      const double column = std::floor(p.x);
      if (!bucket_.empty() && column != column_) flush();
      column_ = column;
      bucket_.push_back(p);
    } else if (!has_last_ || std::fabs(p.x - last_.x) + std::fabs(p.y - last_.y) > 0.33) {
      emit(p);
    } else {
      pending_ = p;
      has_pending_ = true;
    }
  }
  void gap() {
    flush();
    if (has_pending_) emit(pending_);
    has_last_ = false;
  }
  std::string take() {
    gap();
    return std::move(text_);
  }

 private:
  /// First, lowest, highest and last of a column, in the order of the data.
  void flush() {
    if (bucket_.size() <= 4) {
      for (const Point& p : bucket_) emit(p);
    } else {
      const auto by_y = [](const Point& a, const Point& b) { return a.y < b.y; };
      auto low = std::min_element(bucket_.begin(), bucket_.end(), by_y);
      auto high = std::max_element(bucket_.begin(), bucket_.end(), by_y);
      if (high < low) std::swap(low, high);
      emit(bucket_.front());
      emit(*low);
      emit(*high);
      emit(bucket_.back());
    }
    bucket_.clear();
  }
  void emit(const Point& p) {
    if (!has_last_) {
      text_ += "M" + clamped_number(p.x) + " " + clamped_number(p.y);
    } else {
      if (steps_) text_ += "H" + clamped_number(p.x);
      text_ += "L" + clamped_number(p.x) + " " + clamped_number(p.y);
    }
    last_ = p;
    has_last_ = true;
    has_pending_ = false;
  }

  bool columns_;
  bool steps_;
  std::vector<Point> bucket_;
  double column_{};
  Point last_{};
  Point pending_{};
  bool has_last_{false};
  bool has_pending_{false};
  std::string text_;
};

std::string draw_line(const Series& s, const Mapping& map, std::size_t n) {
  bool ascending = true;
  for (std::size_t i = 1; i < n && ascending; ++i) ascending = !(s.x[i] < s.x[i - 1]);
  Path path(ascending, s.mark == Mark::steps);
  for (std::size_t i = 0; i < n; ++i) {
    const Point p{map.px(s.x[i]), map.py(s.y[i])};
    if (std::isfinite(p.x) && std::isfinite(p.y)) {
      path.add(p);
    } else {
      path.gap();
    }
  }
  const std::string text = path.take();
  if (text.empty()) return {};
  return "<path d=\"" + text + "\" fill=\"none\" stroke=\"" + palette(s.colour) + "\" stroke-width=\"" +
         firmware::format_fixed(s.width, 1) + "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"" +
         (s.dashed ? " stroke-dasharray=\"5 4\"" : "") + "/>\n";
}

std::string draw_dots(const Series& s, const Mapping& map, std::size_t n) {
  std::string out = std::string("<g fill=\"") + palette(s.colour) + "\">";
  double last_x = -1e9;
  double last_y = -1e9;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = map.px(s.x[i]);
    const double y = map.py(s.y[i]);
    if (!std::isfinite(x) || !std::isfinite(y) || std::fabs(x - last_x) + std::fabs(y - last_y) < 0.33)
      continue;
    out += "<circle cx=\"" + clamped_number(x) + "\" cy=\"" + clamped_number(y) + "\" r=\"" +
           firmware::format_fixed(i < s.sizes.size() ? s.sizes[i] : 1.5 * s.width, 1) + "\"/>";
    last_x = x;
    last_y = y;
  }
  return out + "</g>\n";
}

std::string draw_bars(const Series& s, const Mapping& map, std::size_t n) {
  std::string out = std::string("<g fill=\"") + palette(s.colour) + "\">";
  const double floor_y = map.frame.top + map.frame.height;
  for (std::size_t i = 0; i < n; ++i) {
    if (!(s.y[i] > 0.0)) continue;
    const double left = std::max(map.px(s.x[i]), map.frame.left);
    const double right = i < s.x_end.size() ? map.px(s.x_end[i]) : left + 1.0;
    const double top = map.py(s.y[i]);
    if (!std::isfinite(left) || !std::isfinite(right) || !std::isfinite(top)) continue;
    out += "<rect x=\"" + clamped_number(left) + "\" y=\"" + clamped_number(std::min(top, floor_y - 2.0)) +
           "\" width=\"" + clamped_number(std::max(1.0, right - left - 0.4)) + "\" height=\"" +
           clamped_number(std::max(2.0, floor_y - top)) + "\"/>";
  }
  return out + "</g>\n";
}

std::string draw_bands(const Series& series, const Mapping& map) {
  std::string out;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.x_end.size()); ++i) {
    const double left = std::max(map.px(series.x[i]), map.frame.left);
    const double right = std::min(map.px(series.x_end[i]), map.frame.left + map.frame.width);
    if (!(right > left)) continue;  // also if NaN
    out += "<rect x=\"" + clamped_number(left) + "\" y=\"" + clamped_number(map.frame.top) + "\" width=\"" +
           clamped_number(right - left) + "\" height=\"" + clamped_number(map.frame.height) + "\" fill=\"" +
           palette(series.colour) + "\" fill-opacity=\"0.16\"/>";
  }
  return out;
}

}  // namespace

std::string draw_series(const Series& series, const Mapping& map) {
  const std::size_t n = std::min(series.x.size(), series.y.size());
  switch (series.mark) {
    case Mark::line:
    case Mark::steps:
      return draw_line(series, map, n);
    case Mark::dots:
      return draw_dots(series, map, n);
    case Mark::bars:
      return draw_bars(series, map, n);
    case Mark::bands:
      return draw_bands(series, map);
  }
  return {};
}

}  // namespace sortie::toolchain
