// SPDX-License-Identifier: BSD-3-Clause
// A robot that keeps what it saw, and another one that is to be recognised on it: as they do on board.
#pragma once

#include <optional>
#include <vector>

#include "mapping/recognition/image_search.hpp"
#include "mapping/recognition/target_keeper.hpp"
#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/place_looks.hpp"
#include "tests/bench/recognition/deceptive_worlds.hpp"
#include "tests/bench/recognition/local_run.hpp"

namespace sortie::bench {

/// A segment and its target are the same thing, as far as places tell.
inline constexpr double kSamePlace_m = 0.4;

/// What the height image of the local map says, of a trial that asks for it.
struct ImageLook {
  mapping::ImageVerdict verdict{};  ///< before any place was refused
  std::optional<PoseError> best;    ///< of the first place, whatever the verdict
  std::int32_t agree{};             ///< cells, of the first place
  double rival{};                   ///< of the second place's score, to the first one's
  mapping::RelocateVerdict scan{};  ///< of the last place that a scan was held against, or none
  std::optional<PoseError> placed;  ///< where `scan` is placed
  mapping::JudgedPlace judged;      ///< by that
  bool confirmed{};                 ///< a look far enough from this one agrees
  double ms{};                      ///< of the search, without that of the scan
  std::uint64_t units{};            ///< of the search
};

/// One search and what came of it.
struct RecognitionLook {
  double way_m{};                  ///< since the second visit began
  std::uint32_t speaking{};        ///< segments that took part
  std::uint32_t kept{};            ///< of these: where a target lies within kSamePlace_m, as the truth has it
  std::uint32_t asked_right{};     ///< of these: that target is among the candidates
  mapping::SetVerdict segments{};  ///< before any place was refused
  std::optional<PoseError> found;  ///< where `segments` is found: what a robot without a map tells
  std::uint32_t agree{};           ///< segments of the first place
  std::uint32_t rival{};           ///< of the second one
  mapping::RelocateVerdict scan{};  ///< of the last place that a scan was held against, or none
  std::optional<PoseError> placed;  ///< where `scan` is placed
  mapping::JudgedPlace judged;      ///< by that
  bool confirmed{};                 ///< a look far enough from this one agrees: a lost robot is placed
  ImageLook image;
};

/// A trial: a look about each metre of the way.
struct RecognitionTrial {
  std::vector<RecognitionLook> looks;
  std::uint32_t targets{};
  std::uint32_t images{};
  double moved{};
  bool is_kept{};
};

/// Settings of a robot.
struct TrialConfig {
  double radius_m{20.0};  ///< of the local maps
  rt::Nanoseconds rest_ns{mapping::SegmentWatchConfig{}.rest_ns};
  int every{2};               ///< one in so many scans goes into the map of surfaces
  bool sparse{true};          ///< lidars of few rays, sparse_lidar(); else those of hall_lidar()
  double look_m{1.0};         ///< of way between two searches
  double most_way_m{1e9};     ///< after which no more are made
  double second_look_m{6.0};  ///< that part `recognise` asks for, between two places that agree
  mapping::RecogniserConfig recogniser;
  mapping::RelocateConfig judge;
  bool images{};  ///< the height image of the local map is asked for, too
  mapping::ImageSearchConfig image_search;
};

/// Drives through a world, both times with smooth segments in voxels of 0.1 m, true odometry from an origin
/// that is anywhere, attitude known to a third of a degree; 0.4 m and half a second between two scans. Of a
/// world that was kept one scan in two is in the map. Searches and judges as part `recognise` does: what the
/// scan refuses is left out, and the search goes on. Throws std::runtime_error where a hall does not fit.
RecognitionTrial try_recognition(const RecognitionWorld& world, const TrialConfig& config,
                                 testing::Draws& draws);

/// The same with scans, poses in the world that was kept, half a second between two: `kept` first, then
/// `now` as another robot, from an origin that is anywhere. The lidar of `config` is not asked for.
RecognitionTrial try_scans(const std::vector<HallScan>& kept, const std::vector<HallScan>& now,
                           const TrialConfig& config, testing::Draws& draws);

}  // namespace sortie::bench
