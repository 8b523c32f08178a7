// SPDX-License-Identifier: BSD-3-Clause
// A robot that is lost looks for itself: matches from starts all about where it may be.
#include <algorithm>

#include "mapping/registration/pose_algebra.hpp"
#include "mapping/registration/scan_registration.hpp"

namespace sortie::mapping {
namespace {
constexpr std::size_t kFewReturns = 512;  ///< of a sample, for starts that are but tried
constexpr double kFoundBetter = 1.02;     ///< of a score: clearly better
constexpr int kTurns = 5;                 ///< about the upright, either way
constexpr int kLattice = 5;               ///< an edge of it
constexpr int kLatticeRadius2 = 5;
constexpr double kCompass[8][2] = {{1, 0},  {0.7, 0.7},   {0, 1},  {-0.7, 0.7},
                                   {-1, 0}, {-0.7, -0.7}, {0, -1}, {0.7, -0.7}};
constexpr double kAsGood = 0.95;         ///< of the best score: as good
constexpr double kFoundApartMove = 0.5;  ///< m and rad: two poses are well apart
constexpr double kFoundApartTurn = 0.17;
}  // namespace

void ScanRegistration::recover(Match& match, const RigidPose& start, const RigidPose& other,
                               const PosePrior& prior) {
  struct Candidate {
    RigidPose pose;
    double value{-1.0};
  };
  Candidate best[3];
  const std::span<const SamplePoint> few = sample_.first(std::min(size_, kFewReturns));
  const auto try_start = [&](const RigidPose& base, const rt::Vector3& turn_rad, const rt::Vector3& move_m) {
    const RigidPose from{base.p + move_m, rt::normalised(rt::exp_rotation(turn_rad) * base.q)};
    Candidate candidate{descend(from, prior, {2, 2, 2}, kFewReturns, match)};
    // The middle layer as well: where the map is but one scan, its rings fit on the rings of the next one
    // wherever that was taken.
    candidate.value = match_score(layers_[0], few, candidate.pose, config_.sigma_m).value +
                      match_score(layers_[1], few, candidate.pose, config_.sigma_m).value;
    for (Candidate& one : best) {
      if (candidate.value > one.value) std::swap(candidate, one);
    }
  };
  // Turns about the upright, which are the usual ones, close together; about all axes on a lattice, or in the
  // plane turns and moves on it. Moves all round.
  const double most = config_.recovery_turn_rad;
  for (const RigidPose* base : {&start, &other}) {
    for (int i = -kTurns; i <= kTurns; ++i) try_start(*base, {0, 0, most * i / kTurns}, {});
    for (int i = 0; i < kLattice * kLattice * kLattice; ++i) {
      const int step[3] = {i % kLattice - 2, i / kLattice % kLattice - 2, i / (kLattice * kLattice) - 2};
      const int flat = step[0] * step[0] + step[1] * step[1];
      if (flat == 0 || flat + step[2] * step[2] > kLatticeRadius2) continue;
      const double x = 0.5 * step[0], y = 0.5 * step[1], z = 0.5 * step[2];
      if (config_.planar) {
        try_start(*base, {0, 0, most * z}, {config_.recovery_move_m * x, config_.recovery_move_m * y, 0});
      } else {
        try_start(*base, {most * x, most * y, most * z}, {});
      }
    }
    for (int i = 0; i < 16; ++i) {
      const double far = i < 8 ? config_.recovery_move_m : 0.5 * config_.recovery_move_m;
      try_start(*base, {}, {far * kCompass[i % 8][0], far * kCompass[i % 8][1], 0.0});
    }
    if (!are_apart(start, other, 0.01, 0.001)) break;
  }
  match.recovered = true;
  const auto value_at = [&](const RigidPose& pose) {
    return match_score(layers_[0], sample(), pose, config_.sigma_m).value +
           match_score(layers_[1], sample(), pose, config_.sigma_m).value;
  };
  double values[4] = {value_at(match.pose)};
  RigidPose poses[4] = {match.pose};
  int chosen = 0;
  for (int i = 1; i < 4; ++i) {
    poses[i] = descend(best[i - 1].pose, prior, {0, 1, config_.steps}, size_, match);
    values[i] = value_at(poses[i]);
    if (values[i] > values[chosen] * (chosen == 0 ? kFoundBetter : 1.0)) chosen = i;
  }
  match.pose = poses[chosen];
  match.other_start = chosen != 0;
  for (int i = 0; i < 4; ++i) {
    match.ambiguous = match.ambiguous || (values[i] > kAsGood * values[chosen] &&
                                          are_apart(poses[i], match.pose, kFoundApartMove, kFoundApartTurn));
  }
}

}  // namespace sortie::mapping
