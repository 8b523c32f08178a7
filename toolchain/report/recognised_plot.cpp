// SPDX-License-Identifier: BSD-3-Clause
// The picture of a recognised place: two maps that are apart, and lines between what is the same in them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "firmware_like/scene/text_format.hpp"
#include "rt/rotation.hpp"
#include "toolchain/report/recognised_places.hpp"

namespace sortie::toolchain {
namespace {

using firmware::format_fixed;
using rt::RecognisedPlace;

constexpr double kCellsAcross = 280;  // across the picture
constexpr double kGap_m = 2.0;        // between the two maps
constexpr double kLeast_m = 0.3;      // over the floor, up to kMost_m: what stands on it
constexpr double kMost_m = 2.0;
constexpr double kRobot_m = 1.0;  // of the arrow
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// Where one of the maps is drawn.
struct Panel {
  Extent x;
  Extent y;
  double move_x_m{};
  double move_y_m{};

  void take(double x_m, double y_m) {
    x.take(x_m);
    y.take(y_m);
  }
  void take(const mapping::PlaceCm& place) { take(0.01 * place.x, 0.01 * place.y); }
  bool holds(double x_m, double y_m) const { return x.holds(x_m) && y.holds(y_m); }
  bool holds(const mapping::PlaceCm& place) const { return holds(0.01 * place.x, 0.01 * place.y); }
  void put(double x_m, double y_m, Series& series) const { series.add(x_m + move_x_m, y_m + move_y_m); }
  void put(const mapping::PlaceCm& place, Series& series) const {
    put(0.01 * place.x, 0.01 * place.y, series);
  }
  /// A line of its own; a NaN stands before the next one.
  void put_line(const std::array<double, 4>& ends, Series& series) const {
    put(ends[0], ends[1], series);
    put(ends[2], ends[3], series);
    series.add(kNothing, kNothing);
  }
};

/// What stands on the floor of the local map.
std::vector<MapPoint> standing(std::vector<MapPoint> points) {
  if (points.empty()) return points;
  std::vector<double> heights;
  for (const MapPoint& point : points) heights.push_back(point.z_m);
  const auto floor = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 20);
  std::nth_element(heights.begin(), floor, heights.end());
  std::erase_if(points, [&](const MapPoint& point) {
    return !(point.z_m > *floor + kLeast_m && point.z_m < *floor + kMost_m);
  });
  return points;
}

/// Poses up to the answer, carried over by T_known_odom where they are drawn on the known map.
std::vector<firmware::TimedPose> way_of(const RecognisedPlace& place,
                                        std::span<const firmware::TimedPose> path, bool on_known) {
  std::vector<firmware::TimedPose> way;
  const rt::Quaternion q = rt::to_quaternion(place.q_known_odom);
  for (firmware::TimedPose pose : path) {
    if (pose.stamp_ns > place.stamp_ns) break;
    if (on_known) {
      rt::store(rt::to_vector(place.p_known_odom_m) + rt::rotate(q, rt::to_vector(pose.p)), pose.p);
      rt::store(q * rt::to_quaternion(pose.q), pose.q);
    }
    way.push_back(pose);
  }
  return way;
}

/// The way, and an arrow head where the robot is.
void put_way(std::span<const firmware::TimedPose> way, const Panel& panel, Series& line) {
  for (const firmware::TimedPose& pose : way) panel.put(pose.p[0], pose.p[1], line);
  line.add(kNothing, kNothing);
  if (way.empty()) return;
  const firmware::TimedPose& last = way.back();
  const rt::Quaternion q = rt::to_quaternion(last.q);
  constexpr double kHead[][2] = {{-0.4, 0.35}, {0.6, 0.0}, {-0.4, -0.35}, {-0.2, 0.0}, {-0.4, 0.35}};
  for (const auto& corner : kHead) {
    const rt::Vector3 at = rt::rotate(q, {kRobot_m * corner[0], kRobot_m * corner[1], 0.0});
    panel.put(last.p[0] + at.x, last.p[1] + at.y, line);
  }
  line.add(kNothing, kNothing);
}

double radius_px(std::uint32_t voxels) { return std::min(2.0 + 0.06 * std::sqrt(voxels), 6.0); }

std::string title_of(const RecognisedAnswer& answer) {
  const RecognisedPlace& place = answer.place;
  std::string title = "After " + format_fixed(answer.time_s, 1) + " s " + verdict_words(place.verdict);
  if (place.verdict == RecognisedPlace::kRecognised || place.verdict == RecognisedPlace::kRefused)
    title += " (" + format_fixed(100.0 * place.share, 0) + " % on surfaces, " +
             format_fixed(100.0 * place.crossed, 1) + " % through)";
  return title;
}

}  // namespace

Plot plot_recognised(const RecognisedLook& look, const KnownPlaces& known,
                     std::span<const firmware::TimedPose> path) {
  const RecognisedPlace& place = look.answer.place;
  const int colour = verdict_colour(place.verdict);
  const std::vector<firmware::TimedPose> way = way_of(place, path, false);
  const std::vector<firmware::TimedPose> laid = way_of(place, path, true);
  const std::vector<MapPoint> seen = standing(look.seen);

  Panel left, right;
  if (!seen.empty()) {
    left.x = bulk_of(seen, &MapPoint::x_m);
    left.y = bulk_of(seen, &MapPoint::y_m);
  }
  for (const auto& line : known.surfaces_m) right.take(line[0], line[1]);
  for (const mapping::PlaceCm& target : known.targets) {
    if (known.surfaces_m.empty()) right.take(target);
  }
  for (const mapping::SweptPair& pair : look.matched) {
    left.take(pair.segment);
    right.take(pair.target);
  }
  for (const firmware::TimedPose& pose : way) left.take(pose.p[0], pose.p[1]);
  for (const firmware::TimedPose& pose : laid) right.take(pose.p[0], pose.p[1]);
  // The known map stays where it is; beside it is what the robot saw, or over it where both are long.
  const double wide = std::max(left.x.size(), right.x.size()), high = std::max(left.y.size(), right.y.size());
  const bool is_beside = wide < 2.0 * high;
  if (is_beside) {
    left.move_x_m = right.x.low - kGap_m - left.x.high;
    left.move_y_m = 0.5 * (right.y.low + right.y.high - left.y.low - left.y.high);
  } else {
    left.move_x_m = 0.5 * (right.x.low + right.x.high - left.x.low - left.x.high);
    left.move_y_m = right.y.high + kGap_m - left.y.low;
  }

  Plot plot{title_of(look.answer), {}, {}, 980, 480, true};
  plot.axes = false;
  Extent x = right.x, y = right.y;
  for (const double end : {left.x.low, left.x.high}) x.take(end + left.move_x_m);
  for (const double end : {left.y.low, left.y.high}) y.take(end + left.move_y_m);
  const MapRaster raster({x.low - 0.5, x.high + 0.5}, {y.low - 0.5, y.high + 1.5}, kCellsAcross, plot);

  Series walls{"surfaces of the known map", Mark::line, kGrey, 1.6};
  for (const auto& line : known.surfaces_m) right.put_line(line, walls);
  Series voxels{"local map", Mark::dots, kGrey, 0.9};
  std::set<MapRaster::Cell> cells;
  for (const MapPoint& point : seen) {
    if (!left.holds(point.x_m, point.y_m)) continue;
    cells.insert(raster.cell(point.x_m + left.move_x_m, point.y_m + left.move_y_m));
  }
  for (const MapRaster::Cell& cell : cells) raster.put(cell, voxels);
  Series targets{"targets of the known map, by size", Mark::dots, kSky, 1.6};
  for (std::size_t i = 0; i < known.targets.size(); ++i) {
    if (!right.holds(known.targets[i])) continue;
    right.put(known.targets[i], targets);
    targets.sizes.push_back(radius_px(known.voxels[i]));
  }
  Series others{"segments that match none of them", Mark::dots, kBlue, 1.8};
  for (const mapping::PlaceCm& other : look.others) {
    if (left.holds(other)) left.put(other, others);
  }
  Series lines{std::to_string(look.matched.size()) + " segments that agree", Mark::line, colour, 1.6};
  Series ends{"", Mark::dots, colour, 2.2};
  for (const mapping::SweptPair& pair : look.matched) {
    left.put(pair.segment, lines);
    right.put(pair.target, lines);
    lines.add(kNothing, kNothing);
    left.put(pair.segment, ends);
    right.put(pair.target, ends);
  }
  Series driven{"the robot and its way", Mark::line, kBlack, 2.0};
  put_way(way, left, driven);
  Series laid_way{"", Mark::line, kBlack, 2.0};
  laid_way.dashed = place.verdict != RecognisedPlace::kRecognised;
  put_way(laid, right, laid_way);
  Series names{"", Mark::dots, kBlack, 0.0};
  const double above_left = (is_beside ? y.high - left.move_y_m : left.y.high) + 0.7;
  const double above_right = (is_beside ? y.high : right.y.high) + 0.7;
  left.put(left.x.low, above_left, names);
  right.put(right.x.low, above_right, names);
  names.labels = {"what the robot sees, as its odometry has it", "what another run kept"};
  for (Series* series : {&walls, &voxels, &targets, &others, &lines, &ends, &driven, &laid_way, &names}) {
    if (!series->x.empty()) plot.series.push_back(std::move(*series));
  }
  return plot;
}

}  // namespace sortie::toolchain
