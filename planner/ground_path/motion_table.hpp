// SPDX-License-Identifier: BSD-3-Clause
// What the tracked robot can do from each heading: drive, curve, back up, turn on the spot.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/ground_path/ground_config.hpp"
#include "planner/ground_path/lattice_heading.hpp"

namespace sortie::planner {

inline constexpr std::uint32_t kMotions = 12;
/// Slots of a cell: 0 to 15 the headings, 16 + i all between heading i and the next on its left.
inline constexpr std::int32_t kStandSlots = 2 * kHeadings;

/// A place on the way of a motion, from its start: the robot stands within half a cell (and a sixteenth) of
/// the cell's middle, with a heading of the slot.
struct MotionStation {
  std::int8_t x{};
  std::int8_t y{};
  std::uint8_t slot{};
  friend constexpr bool operator==(const MotionStation&, const MotionStation&) = default;
};

/// One motion. Its end is its last station.
struct Motion {
  std::int8_t x{};  ///< cells from start to end
  std::int8_t y{};
  std::uint8_t heading{};  ///< at the end
  bool reverse{};
  std::uint16_t first_station{};
  std::uint16_t stations{};
  std::uint32_t time_ms{};
};

/// All motions of all headings. A curve is a parabola that begins along one heading and ends along another
/// one or two on; its time is that of its two legs, which is longer by 3 % at most, or that of its turn.
/// Turned by quarters or mirrored, the table is the same. Whole numbers; 7 kB; made once.
class MotionTable {
 public:
  static constexpr std::uint32_t kMostStations = 1280;

  explicit MotionTable(const GroundPathConfig& config);

  const Motion& motion(std::int32_t heading, std::uint32_t index) const {
    return motions_[static_cast<std::size_t>(heading)][index];
  }
  std::span<const MotionStation> stations(const Motion& motion) const {
    return {stations_.data() + motion.first_station, motion.stations};
  }
  /// ms for a straight step along a heading, and for a curve's leg; forward.
  std::uint32_t step_ms(std::int32_t heading) const;
  std::uint32_t leg_ms(std::int32_t heading) const;
  /// False: the table is too small for it, which no configuration reaches.
  bool is_whole() const { return whole_; }

 private:
  struct Curve;
  void add_straight(std::int32_t heading, bool reverse);
  void add_curve(std::int32_t heading, std::int32_t turn, bool reverse);
  void add_turn(std::int32_t heading, std::int32_t turn);
  Motion& begin(std::int32_t heading);
  void add_samples(Motion& motion, const Curve& curve);
  bool has(const Motion& motion, const MotionStation& station) const;
  void add(Motion& motion, const MotionStation& station);
  std::uint32_t drive_ms(std::int64_t length_q16, bool reverse) const;
  std::uint32_t turn_ms(std::int64_t mrad) const;

  GroundPathConfig config_;
  std::array<std::array<Motion, kMotions>, kHeadings> motions_{};
  std::array<std::uint8_t, kHeadings> counts_{};
  std::array<MotionStation, kMostStations> stations_{};
  std::uint32_t station_count_{};
  bool whole_{true};
};

}  // namespace sortie::planner
