// SPDX-License-Identifier: BSD-3-Clause
// Matches from other starts: all about where a robot that is lost may be; and, where nothing but the scan
// says how far it moved, where other poses may do as well.
#include <algorithm>

#include "mapping/registration/pose_algebra.hpp"
#include "mapping/registration/scan_registration.hpp"
#include "rt/math.hpp"

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
constexpr double kRivalFit = 1.0;            ///< of the share of what is known that fits
constexpr double kSurfaceDeviations2 = 4.0;  ///< squared: a return lies on a surface
constexpr double kRivalKnown = 0.7;          ///< of the share that is known: enough of it to compare
constexpr double kRivalMove = 0.1;           ///< m and rad: the two are not the same
constexpr double kRivalTurn = 0.0174533;
constexpr double kAlong[] = {0.4, 0.8, 1.2, 1.6};  ///< m, either way along what is held least
constexpr double kAcross[] = {0.8, 1.6};           ///< m, either way across it
constexpr double kAbout[] = {0.09, 0.18};          ///< rad, either way about the upright

/// The level direction along which least is held.
rt::Vector3 least_held(const NormalEquations& equations) {
  const auto& h = equations.held;
  const double most = 0.5 * rt::atan2(2.0 * h[3][4], h[3][3] - h[4][4]);
  const rt::Vector3 along = rt::rotate(rt::exp_rotation({0, 0, most}), {1, 0, 0});
  return {-along.y, along.x, 0.0};
}

/// How well a sample lies on the surfaces that it meets, across them alone: where its rings lie on the rings
/// of another scan says nothing of the surface.
struct SurfaceFit {
  std::uint32_t known{};
  std::uint32_t matched{};
};

SurfaceFit surface_fit(const SurfelLayer& layer, std::span<const SamplePoint> sample, const RigidPose& pose,
                       double sigma_m) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  SurfaceFit fit;
  SurfelPlace place;
  for (const SamplePoint& point : sample) {
    const rt::Vector3 p = r * point.at() + pose.p;
    if (!layer.place(p.x, p.y, p.z, place)) continue;
    const Surfel* const surfel = layer.surfel_met(place.cell, p - pose.p);
    if (surfel == nullptr) continue;
    ++fit.known;
    const double off = rt::dot(surfel->normal(), layer.from_centre_m(place) - surfel->mean());
    if (off * off < kSurfaceDeviations2 * (surfel->variance(0) + sigma_m * sigma_m)) ++fit.matched;
  }
  return fit;
}

/// Of what it knows, as much lies on the map: what is not known must not decide.
bool fits_as_well(const SurfaceFit& one, const SurfaceFit& best) {
  return one.known > kRivalKnown * best.known &&
         static_cast<double>(one.matched) * best.known >= kRivalFit * best.matched * one.known;
}
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

void ScanRegistration::look_for_rivals(Match& match, const PosePrior& prior) {
  constexpr std::size_t kStarts = 2 * (std::size(kAlong) + std::size(kAcross) + std::size(kAbout));
  RigidPose ends[kStarts + 1]{match.pose};
  std::size_t count = 1;
  const auto try_start = [&](const rt::Vector3& move_m, double turn_rad) {
    const RigidPose from{match.pose.p + move_m,
                         rt::normalised(rt::exp_rotation({0, 0, turn_rad}) * match.pose.q)};
    ends[count++] = descend(from, prior, {0, 1, 8}, kFewReturns, match);
  };
  const rt::Vector3 along = least_held(match.equations);
  const rt::Vector3 across{-along.y, along.x, 0.0};
  for (const double side : {-1.0, 1.0}) {
    for (const double far : kAlong) try_start(side * far * along, 0.0);
    for (const double far : kAcross) try_start(side * far * across, 0.0);
    for (const double turn : kAbout) try_start({}, side * turn);
  }
  const std::span<const SamplePoint> few = sample_.first(std::min<std::size_t>(size_, 1024));
  SurfaceFit fit[kStarts + 1];
  double value[kStarts + 1];
  std::size_t best = 0;
  for (std::size_t i = 0; i < count; ++i) {
    fit[i] = surface_fit(layers_[0], few, ends[i], config_.sigma_m);
    value[i] = match_score(layers_[0], few, ends[i], config_.sigma_m).value +
               match_score(layers_[1], few, ends[i], config_.sigma_m).value;
    if (value[i] > value[best] * (best == 0 ? kFoundBetter : 1.0)) best = i;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!are_apart(ends[i], ends[best], kRivalMove, kRivalTurn)) continue;
    match.ambiguous = match.ambiguous || value[i] > kAsGood * value[best] || fits_as_well(fit[i], fit[best]);
  }
  if (best != 0) {
    match.other_start = match.other_start || are_apart(ends[best], match.pose, kRivalMove, kRivalTurn);
    match.pose = descend(ends[best], prior, {0, 0, config_.steps}, size_, match);
  }
  match.score = match_score(layers_[0], sample(), match.pose, config_.sigma_m);
  weigh(match);
}

}  // namespace sortie::mapping
