// SPDX-License-Identifier: BSD-3-Clause
// Layout: title, legend row(s), plot area with grid, tick labels, axis labels. The legend never covers data.
#include "toolchain/report/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/label_layout.hpp"
#include "toolchain/report/svg_path.hpp"

namespace sortie::toolchain {
namespace {

constexpr double kFont = 12.0;

/// Average width of a sans-serif character.
double text_width(std::string_view text) { return 0.56 * kFont * static_cast<double>(text.size()); }

/// A log axis has no place for what is not above zero.
void take(double value, const Axis& axis, Extent& range) {
  if (!axis.log || value > 0.0) range.take(value);
}

Scale scale_of(const Axis& axis, const Extent& range, bool padded) {
  double low = range.low;
  double high = range.high;
  if (padded && low <= high) {
    const double room = 0.04 * (high - low);
    low = axis.log ? low / 1.25 : low - room;
    high = axis.log ? high * 1.25 : high + room;
  }
  if (!std::isnan(axis.low)) low = axis.low;
  if (!std::isnan(axis.high)) high = axis.high;
  return make_scale(low, high, axis.log);
}

/// Makes a unit as long on one axis as on the other by widening the axis that has room.
void equalise(Scale& x, Scale& y, const Frame& frame) {
  const double per_px = std::max((x.high - x.low) / frame.width, (y.high - y.low) / frame.height);
  const auto widen = [per_px](Scale& scale, double px) {
    const double middle = 0.5 * (scale.low + scale.high);
    scale.low = middle - 0.5 * per_px * px;
    scale.high = middle + 0.5 * per_px * px;
  };
  widen(x, frame.width);
  widen(y, frame.height);
}

struct LegendEntry {
  const Series* series;
  double x;
  double y;
};

/// Entries in rows above the plot area; `height` is what they need.
std::vector<LegendEntry> lay_legend(const Plot& plot, double left, double top, double& height) {
  std::vector<LegendEntry> entries;
  double x = left;
  double y = top + 8.0;
  for (const Series& series : plot.series) {
    if (series.name.empty()) continue;
    const double needed = 26.0 + text_width(series.name) + 16.0;
    if (x > left && x + needed > plot.width) {
      x = left;
      y += 18.0;
    }
    entries.push_back({&series, x, y});
    x += needed;
  }
  height = entries.empty() ? 0.0 : y - top + 12.0;
  return entries;
}

std::string number(double value) { return firmware::format_fixed(value, 1); }

std::string text(double x, double y, std::string_view words, const char* anchor, const char* more = "") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
         escape_xml(words) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const char* style) {
  return "<line x1=\"" + number(x1) + "\" y1=\"" + number(y1) + "\" x2=\"" + number(x2) + "\" y2=\"" +
         number(y2) + "\" " + style + "/>";
}

std::string draw_axes(const Plot& plot, const Mapping& map) {
  const Frame& f = map.frame;
  std::string out;
  constexpr const char* kMajor = "stroke=\"#d5d9de\" stroke-width=\"1\"";
  constexpr const char* kMinor = "stroke=\"#eceff2\" stroke-width=\"1\"";
  for (const Tick& tick : make_ticks(map.x, static_cast<int>(f.width / 80.0))) {
    const double x = map.px(tick.value);
    out += line(x, f.top, x, f.top + f.height, tick.label.empty() ? kMinor : kMajor);
    if (!tick.label.empty()) out += text(x, f.top + f.height + 16.0, tick.label, "middle");
  }
  for (const Tick& tick : make_ticks(map.y, std::max(3, static_cast<int>(f.height / 40.0)))) {
    const double y = map.py(tick.value);
    out += line(f.left, y, f.left + f.width, y, tick.label.empty() ? kMinor : kMajor);
    if (!tick.label.empty()) out += text(f.left - 6.0, y + 4.0, tick.label, "end");
  }
  out += "<rect x=\"" + number(f.left) + "\" y=\"" + number(f.top) + "\" width=\"" + number(f.width) +
         "\" height=\"" + number(f.height) + "\" fill=\"none\" stroke=\"#8a939c\"/>\n";
  out += text(f.left + f.width / 2.0, f.top + f.height + 34.0, plot.x.label, "middle", " fill=\"#3d454d\"");
  const double middle = f.top + f.height / 2.0;
  const std::string turn = " fill=\"#3d454d\" transform=\"rotate(-90 14 " + number(middle) + ")\"";
  out += text(14.0, middle, plot.y.label, "middle", turn.c_str());
  return out;
}

// Under the area, a fifth of it or less.
std::string draw_scale_bar(const Mapping& map) {
  const Frame& f = map.frame;
  const double metre_px = f.width / (map.x.high - map.x.low);
  const double most_m = 0.2 * f.width / metre_px;
  double length_m = std::pow(10.0, std::floor(std::log10(most_m)));
  length_m *= most_m >= 5.0 * length_m ? 5.0 : most_m >= 2.0 * length_m ? 2.0 : 1.0;
  const double y = f.top + f.height + 12.0, end = f.left + length_m * metre_px;
  constexpr const char* kInk = "stroke=\"#3d454d\" stroke-width=\"1.4\"";
  return line(f.left, y, end, y, kInk) + line(f.left, y - 4.0, f.left, y + 4.0, kInk) +
         line(end, y - 4.0, end, y + 4.0, kInk) +
         text(end + 7.0, y + 4.0, firmware::format_short(length_m) + " m", "start", " fill=\"#3d454d\"");
}

// `taken`: gets the place of each text.
std::string draw_rules(const Plot& plot, const Mapping& map, std::vector<LabelBox>& taken) {
  const Frame& f = map.frame;
  std::string out;
  double stagger = 0.0;  // labels of neighbouring rules do not cover each other
  for (const Rule& rule : plot.rules) {
    const double at = map.px(rule.value);
    if (!(at >= f.left && at <= f.left + f.width)) continue;  // also if NaN
    const std::string style =
        std::string("stroke=\"") + palette(rule.colour) + "\" stroke-width=\"1.4\" stroke-dasharray=\"6 3\"";
    const std::string ink = std::string(" class=\"halo\" fill=\"") + palette(rule.colour) + "\"";
    out += line(at, f.top, at, f.top + f.height, style.c_str());
    const bool left_side = at > f.left + 0.6 * f.width;
    const double x = at + (left_side ? -5.0 : 5.0);
    const double y = f.top + 14.0 + stagger;
    out += text(x, y, rule.label, left_side ? "end" : "start", ink.c_str());
    const double left = left_side ? x - text_width(rule.label) : x;
    taken.push_back({left, y - 11.0, left + text_width(rule.label), y + 4.0});
    stagger += 16.0;
  }
  return out;
}

// Texts beside points, where they cover neither each other nor the rules' texts.
std::string draw_labels(const Plot& plot, const Mapping& map, const std::vector<LabelBox>& taken) {
  std::vector<std::string_view> texts;
  std::vector<double> x;
  std::vector<double> y;
  for (const Series& s : plot.series) {
    for (std::size_t i = 0; i < std::min({s.labels.size(), s.x.size(), s.y.size()}); ++i) {
      const double px = map.px(s.x[i]);
      const double py = map.py(s.y[i]);
      if (s.labels[i].empty() || !std::isfinite(px) || !std::isfinite(py)) continue;
      texts.emplace_back(s.labels[i]);
      x.push_back(px);
      y.push_back(py);
    }
  }
  const std::vector<PlacedLabel> placed = lay_labels(texts, x, y, map.frame, taken);
  const std::string ink = std::string(" class=\"halo\" font-size=\"11\" fill=\"") + palette(6) + "\"";
  std::string leads;
  std::string out;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PlacedLabel& place = placed[i];
    if (place.is_far)
      leads += line(x[i], y[i], place.x, place.y < y[i] ? place.y + 3.0 : place.y - 9.0,
                    "stroke=\"#9aa3ab\" stroke-width=\"0.7\"");
    out += text(place.x, place.y, texts[i], place.ends_there ? "end" : "start", ink.c_str());
  }
  return leads + out;
}

std::string draw_legend(const std::vector<LegendEntry>& entries) {
  std::string out;
  for (const LegendEntry& entry : entries) {
    const Series& s = *entry.series;
    const std::string colour = palette(s.colour);
    if (s.mark == Mark::bands) {
      out += "<rect x=\"" + number(entry.x) + "\" y=\"" + number(entry.y - 6.0) +
             "\" width=\"20\" height=\"12\" fill=\"" + colour + "\" fill-opacity=\"0.3\"/>";
    } else if (s.mark == Mark::bars || s.mark == Mark::dots) {
      const double size = s.mark == Mark::bars ? 10.0 : 6.0;
      out += "<rect x=\"" + number(entry.x + 10.0 - size / 2.0) + "\" y=\"" + number(entry.y - size / 2.0) +
             "\" width=\"" + number(size) + "\" height=\"" + number(size) + "\" rx=\"" +
             number(s.mark == Mark::dots ? 3.0 : 1.0) + "\" fill=\"" + colour + "\"/>";
    } else {
      const std::string style = "stroke=\"" + colour + "\" stroke-width=\"" + number(s.width) + "\"" +
                                (s.dashed ? " stroke-dasharray=\"5 4\"" : "");
      out += line(entry.x, entry.y, entry.x + 20.0, entry.y, style.c_str());
    }
    out += text(entry.x + 26.0, entry.y + 4.0, s.name, "start");
  }
  return out;
}

}  // namespace

void Extent::take(double value) {
  if (!std::isfinite(value)) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void Extent::take(const std::vector<double>& values) {
  for (const double value : values) take(value);
}

const char* palette(int index) {
  static constexpr std::array<const char*, 8> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                       "#e69f00", "#56b4e9", "#1a1a1a", "#9aa3ab"};
  return kColours[static_cast<std::size_t>(index) % kColours.size()];
}

std::string escape_xml(std::string_view words) {
  static constexpr std::pair<char, const char*> kNames[] = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
  std::string out;
  for (const char c : words) {
    const auto* name = std::find_if(std::begin(kNames), std::end(kNames),
                                    [c](const auto& entry) { return entry.first == c; });
    if (name != std::end(kNames)) {
      out += name->second;
    } else if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') {
      out += c;
    }
  }
  return out;
}

std::string render(const Plot& plot) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Extent x_range{kInfinity, -kInfinity};
  Extent y_range = x_range;
  bool has_bars = false;
  for (const Series& s : plot.series) {
    has_bars = has_bars || s.mark == Mark::bars;
    for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
      if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i]) || (plot.y.log && s.y[i] <= 0.0)) continue;
      take(s.x[i], plot.x, x_range);
      if (i < s.x_end.size()) take(s.x_end[i], plot.x, x_range);
      take(s.y[i], plot.y, y_range);
    }
  }
  const bool empty = !(x_range.low <= x_range.high);
  for (const Rule& rule : plot.rules) {
    if (!empty) take(rule.value, plot.x, x_range);
  }
  Mapping map;
  double top = plot.title.empty() ? 4.0 : 26.0;
  double legend_height = 0.0;
  const double left = plot.axes ? 60.0 : 14.0;
  const std::vector<LegendEntry> legend = lay_legend(plot, left, top, legend_height);
  top += legend_height + 4.0;
  map.frame = {left, top, plot.width - left - 14.0, plot.height - top - (plot.axes ? 42.0 : 24.0)};
  map.x = scale_of(plot.x, x_range, plot.x.log || plot.equal_aspect || has_bars);
  map.y = scale_of(plot.y, y_range, true);
  if (plot.equal_aspect) equalise(map.x, map.y, map.frame);

  std::string out =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(plot.width) + " " +
      number(plot.height) + "\" width=\"" + number(plot.width) + "\" height=\"" + number(plot.height) +
      "\" role=\"img\" font-family=\"system-ui, 'DejaVu Sans', Arial, sans-serif\" font-size=\"12\" "
      "fill=\"#1a1f24\">\n<style>.halo{paint-order:stroke;stroke:#fff;stroke-width:3px}</style>\n";
  out += "<title>" + escape_xml(plot.title.empty() ? plot.y.label + " over " + plot.x.label : plot.title) +
         "</title>\n";
  if (!plot.title.empty())
    out += text(left, 17.0, plot.title, "start", " font-size=\"14\" font-weight=\"600\"");
  out += (plot.axes ? draw_axes(plot, map) : draw_scale_bar(map)) + "\n";
  const Frame& f = map.frame;
  // A nested viewport clips to the plot area without an id, so plots can share one page.
  out += "<svg x=\"" + number(f.left) + "\" y=\"" + number(f.top) + "\" width=\"" + number(f.width) +
         "\" height=\"" + number(f.height) + "\" viewBox=\"" + number(f.left) + " " + number(f.top) + " " +
         number(f.width) + " " + number(f.height) + "\" overflow=\"hidden\">\n";
  for (const Series& s : plot.series) out += draw_series(s, map);
  out += "</svg>\n";
  if (empty)
    out += text(f.left + f.width / 2.0, f.top + f.height / 2.0, "no data", "middle", " fill=\"#6b747d\"");
  std::vector<LabelBox> taken;
  out += draw_rules(plot, map, taken);
  out += draw_labels(plot, map, taken) + draw_legend(legend) + "</svg>\n";
  return out;
}

std::string render_bar(double share, int colour, double width) {
  constexpr double height = 9;
  const double filled = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) * width : 0.0;
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(width) + "\" height=\"" +
         number(height) + "\" role=\"img\"><rect width=\"" + number(width) + "\" height=\"" + number(height) +
         "\" rx=\"2\" fill=\"#e4e8ec\"/><rect width=\"" + number(filled) + "\" height=\"" + number(height) +
         "\" rx=\"2\" fill=\"" + palette(colour) + "\"/></svg>";
}

}  // namespace sortie::toolchain
