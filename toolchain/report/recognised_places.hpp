// SPDX-License-Identifier: BSD-3-Clause
// What a robot recognised on a known map: every answer, and which segments the newest places rest on.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware_like/log/timed_pose.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "mapping/recognition/consistency_gate.hpp"
#include "rt/recognised_place.hpp"
#include "toolchain/report/map_plot.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// An answer of task `recognise`.
struct RecognisedAnswer {
  double time_s{};  ///< when its segments were looked at, from the start of the log
  rt::RecognisedPlace place;
};

/// An answer that has a place, and what was there when it came.
struct RecognisedLook {
  RecognisedAnswer answer;
  std::vector<mapping::SweptPair> matched;  ///< segments in the odometry's world, targets on the known map
  std::vector<mapping::PlaceCm> others;     ///< segments that were asked for and are not among those
  std::vector<MapPoint> seen;               ///< the local map, in the odometry's world
};

/// The known map as the run began with it.
struct KnownPlaces {
  std::vector<mapping::PlaceCm> targets;
  std::vector<std::uint32_t> voxels;              ///< of each target
  std::vector<std::array<double, 4>> surfaces_m;  ///< of --map: upright ones as lines, x y x y; or none
};

/// Follows the jobs of task `recognise`, if the scene has one and knows targets. Memory: 280 bytes an answer,
/// two local maps and the known one.
class RecognisedPlaces {
 public:
  /// After each job of any group, on the thread that ran it, one at a time (ReplayOptions::on_job).
  void job(const rt::JobRecord& record, const firmware::Runtime& runtime);

  const std::vector<RecognisedAnswer>& answers() const { return answers_; }
  /// The newest place that was recognised; where there is none, the newest that no scan was held against.
  const std::optional<RecognisedLook>& accepted() const { return accepted_; }
  /// The newest one that segments speak for and that was refused, by the scan or by what the set is like.
  const std::optional<RecognisedLook>& refused() const { return refused_; }
  const KnownPlaces& known() const { return known_; }

 private:
  void find(const firmware::Runtime& runtime);
  void know(const firmware::Runtime& runtime);
  RecognisedLook look(const RecognisedAnswer& answer, const firmware::Runtime& runtime) const;

  const firmware::Runtime* runtime_{};
  const rt::TaskBase* task_{};
  std::uint64_t seen_{};  ///< answers
  std::vector<RecognisedAnswer> answers_;
  std::optional<RecognisedLook> accepted_;
  std::optional<RecognisedLook> refused_;
  KnownPlaces known_;
};

/// What became of an answer, in words, by its verdict (RecognisedPlace).
const char* verdict_words(std::uint8_t verdict);

/// The same in colour: of a place that is recognised, that nothing was held against, or that was refused.
int verdict_colour(std::uint8_t verdict);

/// From above, side by side or one above the other: on one side what the robot saw and its way up to then, as
/// its odometry has them, on the other one the known map with that way where the answer lays it; a line joins
/// each segment with its target. Targets are as large as they have voxels. Of the local map what stands on
/// the floor is shown, up to 2 m; a few far voxels and targets are left out.
Plot plot_recognised(const RecognisedLook& look, const KnownPlaces& known,
                     std::span<const firmware::TimedPose> path);

/// What the page shows of it; without answers nothing.
struct RecognisedReport {
  std::vector<RecognisedAnswer> answers;
  Plot accepted;  ///< without series: no such place
  Plot refused;
};
RecognisedReport report_of(const RecognisedPlaces& places, std::span<const firmware::TimedPose> path);

/// The pictures, and a table with a row for each span of equal verdicts.
std::string recognised_section(const RecognisedReport& report);

}  // namespace sortie::toolchain
