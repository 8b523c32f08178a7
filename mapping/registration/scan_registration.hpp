// SPDX-License-Identifier: BSD-3-Clause
// A scan's pose on the map: matching from a start, a dozen starts about the result, and many where it was
// lost.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/match_score.hpp"
#include "mapping/registration/registration_config.hpp"
#include "mapping/registration/weak_directions.hpp"
#include "rt/arena.hpp"

namespace sortie::mapping {

/// Three layers of surfels over the same points, the cells of each twice as long as those of the one before.
inline constexpr int kSurfelLayers = 3;

/// What a match found.
struct Match {
  RigidPose pose;  ///< map from sensor
  MatchScore score;
  NormalEquations equations;  ///< at the pose, finest layer, with noise
  WeakDirections weak;        ///< of these
  double spread[6][6]{};      ///< of where starts about the pose ended that did as well: (turn, move)
  std::uint32_t steps{};      ///< spent, each of at most the sample's returns
  bool alone{};               ///< the prior leaves metres open
  bool recovered{};           ///< other starts were tried
  bool other_start{};         ///< the pose comes from another start than the given one
  bool ambiguous{};           ///< another pose, well apart, did as well
};

/// Registration of scans to a map that it keeps. All memory comes from an arena; no heap afterwards. The same
/// bits whatever the order of a scan's points; arithmetic of rt/math alone.
class ScanRegistration {
 public:
  /// Throws nothing; `arena` says what it had no room for.
  ScanRegistration(const RegistrationConfig& config, rt::Arena& arena, const RegistrationMemory& memory = {});

  /// Takes a scan's sample; the calls below are about it. How many returns it has.
  std::size_t take(std::span<const rt::ScanPoint> scan);
  /// For a registration in the plane, whose poses have neither height nor tilt: turns what was taken by the
  /// sensor's tilt, and puts it on the plane.
  void lay_flat(const rt::Quaternion& tilt);
  /// Matches from `start`. Where that does not do, or does much worse than `usual_share` of the scan before,
  /// also from turns of it and of `other`.
  Match match(const RigidPose& start, const RigidPose& other, const PosePrior& prior, double usual_share);
  /// Takes a sample that was chosen before, of this scan or another one: sample() then. No more returns than
  /// a scan's.
  std::size_t take_sample(std::span<const SamplePoint> sample);
  /// Matches the first `returns` of the sample from one start alone, with the finest layer and, where that
  /// does not do, with the coarse ones first: for who has many starts of his own. Steps it spends: at most 4
  /// and twice those of the config.
  Match match_from(const RigidPose& start, const PosePrior& prior, std::size_t returns);
  /// Looks from starts about a match's pose, with all of the sample, and takes a better one: Match::spread.
  void match_about(Match& match, const PosePrior& prior);
  /// Adds the sample to the map at a pose.
  void insert(const RigidPose& pose);

  const RegistrationConfig& config() const { return config_; }
  const SurfelLayer& layer(int level) const { return layers_[level]; }
  /// The same, for who puts a kept map into it (surfel_map.hpp).
  SurfelLayer& layer_to_load(int level) { return layers_[level]; }
  std::span<const SamplePoint> sample() const { return sample_.first(size_); }
  /// All that was chosen of the scan, the sample first.
  std::span<const SamplePoint> chosen() const { return sample_.first(chosen_); }
  /// It is of the scan that was taken last, and of no sample that somebody took since.
  bool is_taken() const { return taken_; }
  const ScanSampleCounts& counts() const { return counts_; }
  /// The map; what was taken of a scan is no part of it.
  void archive(rt::Archive& archive);

 private:
  struct Ladder {
    std::uint32_t coarse, middle, fine;
  };
  RigidPose descend(RigidPose pose, const PosePrior& prior, const Ladder& ladder, std::size_t returns,
                    Match& match);
  bool look_about(Match& match, const PosePrior& prior);
  void weigh(Match& match);
  /// Starts along what is held least, across it and about the upright. A better end is taken; where another
  /// does as well, or fits what it knows as well, the match is ambiguous.
  void look_for_rivals(Match& match, const PosePrior& prior);
  void recover(Match& match, const RigidPose& start, const RigidPose& other, const PosePrior& prior);
  SurfelLayer make_layer(rt::Arena& arena, int level, const RegistrationMemory& memory) const;

  RegistrationConfig config_;
  SurfelLayer layers_[kSurfelLayers];
  ScanStep step_;
  ScanSample chooser_;
  std::span<SamplePoint> sample_;
  std::span<rt::Vector3> points_;
  std::span<std::uint64_t> cells_;
  std::size_t chosen_{};  ///< of the scan
  std::size_t size_{};  ///< of them that are matched; the order is by chance, so the first are as good as any
  bool taken_{};
  std::uint32_t scans_{};
  ScanSampleCounts counts_;
};

}  // namespace sortie::mapping
