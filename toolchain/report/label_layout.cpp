// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/report/label_layout.hpp"

#include <limits>

namespace sortie::toolchain {

namespace {

constexpr double kAscent = 10.0;  // of the letters above their base line, and below
constexpr double kDescent = 3.0;
constexpr double kMark = 5.0;  // half of a point's mark
constexpr double kRow = 14.0;

bool covers(const LabelBox& a, const LabelBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

LabelBox box_of(const PlacedLabel& label, double width) {
  const double left = label.ends_there ? label.x - width : label.x;
  return {left, label.y - kAscent, left + width, label.y + kDescent};
}

// From the nearest: beside the point above and below, then rows further away.
std::vector<PlacedLabel> places_about(double x, double y, bool left_first) {
  std::vector<PlacedLabel> places;
  for (int row = 0; row <= 12; ++row) {
    for (const double side : {-1.0, 1.0}) {
      const double base = side < 0 ? y - 6.0 - kRow * row : y + 13.0 + kRow * row;
      for (const bool left : {left_first, !left_first})
        places.push_back({x + (left ? -7.0 : 7.0), base, left, row > 0});
    }
  }
  return places;
}

}  // namespace

double label_width(std::string_view text) { return 0.56 * 11.0 * static_cast<double>(text.size()); }

std::vector<PlacedLabel> lay_labels(const std::vector<std::string_view>& texts, const std::vector<double>& x,
                                    const std::vector<double>& y, const Frame& frame,
                                    std::vector<LabelBox> taken) {
  std::vector<PlacedLabel> placed;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const double width = label_width(texts[i]);
    double least = std::numeric_limits<double>::infinity();
    PlacedLabel best;
    double distance = 0;
    for (const PlacedLabel& place : places_about(x[i], y[i], x[i] > frame.left + 0.8 * frame.width)) {
      const LabelBox box = box_of(place, width);
      double cost = distance++;
      const bool outside = box.left < frame.left || box.right > frame.left + frame.width ||
                           box.top < frame.top || box.bottom > frame.top + frame.height;
      if (outside) cost += 10000;
      for (const LabelBox& other : taken) cost += covers(box, other) ? 1000 : 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        cost += covers(box, {x[k] - kMark, y[k] - kMark, x[k] + kMark, y[k] + kMark}) ? 5 : 0;
      }
      if (cost < least) {
        least = cost;
        best = place;
      }
    }
    taken.push_back(box_of(best, width));
    placed.push_back(best);
  }
  return placed;
}

}  // namespace sortie::toolchain
