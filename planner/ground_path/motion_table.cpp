// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/motion_table.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

constexpr std::int32_t kSamples =
    64;  // of a motion; along an axis they are a sixteenth of a cell apart at most

constexpr std::int32_t cross(const CellStep& a, const CellStep& b) { return a.x * b.y - a.y * b.x; }

// Cells whose middle is nearest to n / kSamples^2: one, or two where it lies half-way.
struct Nearest {
  std::int32_t low{};
  std::int32_t high{};
};
constexpr Nearest nearest_cells(std::int32_t n) {
  constexpr std::int32_t kUnit = kSamples * kSamples;
  const std::int32_t shifted = n + kUnit / 2 + 64 * kUnit;  // above 0
  const std::int32_t high = shifted / kUnit - 64;
  return {shifted % kUnit == 0 ? high - 1 : high, high};
}

}  // namespace

// From the start along the first leg, which the way leaves at once, to the end along the second.
struct MotionTable::Curve {
  CellStep corner;
  CellStep end;
  std::int32_t heading{};
  std::int32_t turn{};  // headings to the left, negative to the right
  std::int32_t sign{};  // -1 backwards
};

MotionTable::MotionTable(const GroundPathConfig& config)
    : config_(check(config) == Status::ok ? config : GroundPathConfig{}) {
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    for (const bool reverse : {false, true}) {
      add_straight(h, reverse);
      for (const std::int32_t turn : {1, -1, 2, -2}) add_curve(h, turn, reverse);
    }
    add_turn(h, 1);
    add_turn(h, -1);
  }
}

std::uint32_t MotionTable::drive_ms(std::int64_t length_q16, bool reverse) const {
  const std::int64_t speed = reverse ? config_.reverse_mm_s : config_.speed_mm_s;
  return static_cast<std::uint32_t>(
      std::max<std::int64_t>(1, length_q16 * config_.cell_mm * 1000 / (65536 * speed)));
}
std::uint32_t MotionTable::turn_ms(std::int64_t mrad) const {
  return static_cast<std::uint32_t>(std::max<std::int64_t>(1, mrad * 1000 / config_.turn_mrad_s));
}
std::uint32_t MotionTable::step_ms(std::int32_t heading) const {
  return drive_ms(step_length_q16(heading), false);
}
std::uint32_t MotionTable::leg_ms(std::int32_t heading) const {
  return (heading % 4 == 0 ? 2 : 1) * step_ms(heading);
}

Motion& MotionTable::begin(std::int32_t heading) {
  const auto h = static_cast<std::size_t>(heading);
  Motion& motion = motions_[h][counts_[h]++];
  motion.first_station = static_cast<std::uint16_t>(station_count_);
  return motion;
}

bool MotionTable::has(const Motion& motion, const MotionStation& station) const {
  const auto all = stations(motion);
  return std::find(all.begin(), all.end(), station) != all.end();
}

void MotionTable::add(Motion& motion, const MotionStation& station) {
  if (station_count_ == kMostStations) {
    whole_ = false;
    return;
  }
  stations_[station_count_++] = station;
  ++motion.stations;
}

// First what lies nearest to one cell; then what lies half-way, where none of its cells is there yet: all of
// them, or the mirrored motion would have others.
void MotionTable::add_samples(Motion& motion, const Curve& curve) {
  for (const bool tied : {false, true}) {
    for (std::int32_t k = 1; k < kSamples; ++k) {
      const std::int32_t s = curve.turn == 0 ? 0 : 2 * k * (kSamples - k);
      const std::int32_t q = curve.turn == 0 ? k * kSamples : k * k;
      const Nearest x = nearest_cells(s * curve.corner.x + q * curve.end.x);
      const Nearest y = nearest_cells(s * curve.corner.y + q * curve.end.y);
      if ((x.low != x.high || y.low != y.high) != tied) continue;
      std::int32_t slot = curve.heading;
      if (curve.turn != 0) {
        const CellStep d{(kSamples - k) * curve.corner.x + k * (curve.end.x - curve.corner.x),
                         (kSamples - k) * curve.corner.y + k * (curve.end.y - curve.corner.y)};
        const std::int32_t way = curve.turn > 0 ? 1 : -1;
        const CellStep next = kHeadingSteps[static_cast<std::size_t>(wrap_heading(curve.heading + way))];
        const bool beyond = (curve.turn == 2 || curve.turn == -2) && way * curve.sign * cross(next, d) > 0;
        const std::int32_t from = curve.heading + (beyond ? way : 0);
        slot = kHeadings + wrap_heading(way > 0 ? from : from - 1);
      }
      bool known = false;
      for (const std::int32_t cx : {x.low, x.high})
        for (const std::int32_t cy : {y.low, y.high})
          known = known || (curve.turn == 0 && cx == 0 && cy == 0) ||
                  (curve.turn == 0 && cx == curve.end.x && cy == curve.end.y) ||
                  has(motion, {static_cast<std::int8_t>(cx), static_cast<std::int8_t>(cy),
                               static_cast<std::uint8_t>(slot)});
      if (known) continue;
      for (std::int32_t cx = x.low; cx <= x.high; ++cx)
        for (std::int32_t cy = y.low; cy <= y.high; ++cy)
          add(motion,
              {static_cast<std::int8_t>(cx), static_cast<std::int8_t>(cy), static_cast<std::uint8_t>(slot)});
    }
  }
  add(motion, {motion.x, motion.y, motion.heading});
}

void MotionTable::add_straight(std::int32_t heading, bool reverse) {
  Motion& motion = begin(heading);
  const CellStep step = kHeadingSteps[static_cast<std::size_t>(heading)];
  const std::int32_t sign = reverse ? -1 : 1;
  const CellStep end{sign * step.x, sign * step.y};
  motion.x = static_cast<std::int8_t>(end.x);
  motion.y = static_cast<std::int8_t>(end.y);
  motion.heading = static_cast<std::uint8_t>(heading);
  motion.reverse = reverse;
  motion.time_ms = drive_ms(step_length_q16(heading), reverse);
  add_samples(motion, {end, end, heading, 0, sign});
}

void MotionTable::add_curve(std::int32_t heading, std::int32_t turn, bool reverse) {
  Motion& motion = begin(heading);
  const std::int32_t last = wrap_heading(heading + turn);
  const CellStep a = curve_leg(heading);
  const CellStep b = curve_leg(last);
  const std::int32_t sign = reverse ? -1 : 1;
  const CellStep end{sign * (a.x + b.x), sign * (a.y + b.y)};
  motion.x = static_cast<std::int8_t>(end.x);
  motion.y = static_cast<std::int8_t>(end.y);
  motion.heading = static_cast<std::uint8_t>(last);
  motion.reverse = reverse;
  std::int64_t mrad = 0;
  for (std::int32_t k = 0; k < (turn > 0 ? turn : -turn); ++k)
    mrad += turn_left_mrad(wrap_heading(turn > 0 ? heading + k : last + k));
  // The legs one by one: a whole number of straight steps, which the distance to the goal counts with.
  const auto leg = [&](std::int32_t h) {
    return (h % 4 == 0 ? 2 : 1) * drive_ms(step_length_q16(h), reverse);
  };
  motion.time_ms = std::max(leg(heading) + leg(last), turn_ms(mrad));
  add_samples(motion, {{sign * a.x, sign * a.y}, end, heading, turn, sign});
}

void MotionTable::add_turn(std::int32_t heading, std::int32_t turn) {
  Motion& motion = begin(heading);
  motion.heading = static_cast<std::uint8_t>(wrap_heading(heading + turn));
  const std::int32_t between = wrap_heading(turn > 0 ? heading : heading - 1);
  motion.time_ms = turn_ms(turn_left_mrad(between));
  add(motion, {0, 0, static_cast<std::uint8_t>(kHeadings + between)});
  add(motion, {0, 0, motion.heading});
}

}  // namespace sortie::planner
