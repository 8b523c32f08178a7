// SPDX-License-Identifier: BSD-3-Clause
// Plots as SVG text: lines, bars and dots on linear or log axes. No script, no font file, no dependency;
// readable in print and without colour vision (Okabe and Ito's palette, and dashes).
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::toolchain {

/// Indices into the palette.
inline constexpr int kBlue = 0;
inline constexpr int kVermilion = 1;
inline constexpr int kGreen = 2;
inline constexpr int kOrange = 4;
inline constexpr int kSky = 5;
inline constexpr int kBlack = 6;
inline constexpr int kGrey = 7;

/// How a series is drawn.
enum class Mark {
  line,   ///< points joined; a NaN breaks the line
  steps,  ///< horizontal to the next x, then up or down
  dots,
  bars,   ///< from the axis to y, each from x to x_end
  bands,  ///< the whole height, each from x to x_end, faint; they have no y and move no axis
};

/// Points of one colour and one legend entry.
struct Series {
  std::string name{};  ///< in the legend; empty = no entry
  Mark mark{Mark::line};
  int colour{0};      ///< index into the palette
  double width{1.6};  ///< of lines, px
  bool dashed{false};
  std::vector<double> x{};
  std::vector<double> y{};
  std::vector<double> x_end{};        ///< right edges of bars
  std::vector<std::string> labels{};  ///< text beside each point; empty: none
  std::vector<double> sizes{};        ///< radius of each dot, px; empty: as the width says

  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
};

/// A line across the plot at one x, with its name at the end.
struct Rule {
  double value{};
  std::string label;
  int colour{1};
};

/// One axis. Limits that are NaN follow the data.
struct Axis {
  std::string label{};
  bool log{false};
  double low{std::numeric_limits<double>::quiet_NaN()};
  double high{std::numeric_limits<double>::quiet_NaN()};
};

/// From the lowest to the highest of finite values; of none, low is above high.
struct Extent {
  double low{1e300};
  double high{-1e300};

  void take(double value);
  void take(const std::vector<double>& values);
  bool holds(double value) const { return value >= low && value <= high; }
  /// 0 of none.
  double size() const { return high > low ? high - low : 0.0; }
};

/// A plot with one pair of axes.
struct Plot {
  std::string title{};  ///< drawn above, empty = none
  Axis x{};
  Axis y{};
  double width{640};  ///< px
  double height{320};
  bool equal_aspect{false};  ///< a metre is as long on both axes
  bool axes{true};           ///< false, of equal aspect: a bar of some metres in their place
  std::vector<Series> series{};
  std::vector<Rule> rules{};
};

/// Colours that stay apart for all common kinds of colour vision: blue, vermilion, green, purple, orange,
/// sky, black, grey. `index` is taken modulo 8.
const char* palette(int index);

/// `text` with &, <, >, " and ' replaced, control characters dropped: safe in XML text and attributes.
std::string escape_xml(std::string_view text);

/// The plot as one <svg> element, well-formed XML. Points closer than a third of a pixel are left out, so
/// size is bounded by the picture, not by the data. Without data it says so.
std::string render(const Plot& plot);

/// A horizontal bar for table cells: `share` (0..1) filled, in `colour`.
std::string render_bar(double share, int colour, double width);

}  // namespace sortie::toolchain
