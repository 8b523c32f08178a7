// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/scan_registration.hpp"

#include <algorithm>
#include <bit>

namespace sortie::mapping {
namespace {
constexpr std::size_t kMostInserted = 16384;  ///< returns of a scan that go into the map
constexpr std::size_t kFewReturns = 640;      ///< of a sample, for starts that are but tried
}  // namespace

SurfelLayer ScanRegistration::make_layer(rt::Arena& arena, int level, std::uint32_t most, unsigned bits_xy,
                                         unsigned bits_z) const {
  static constexpr const char* kNames[] = {"surfels_fine", "surfels_middle", "surfels_coarse"};
  const auto shift = static_cast<unsigned>(level);
  const std::uint32_t count = std::max(most >> (2 * shift), 256u);
  const SurfelLayerMemory memory{
      arena.make_array<SurfelIndex>(kNames[level],
                                    std::size_t{1} << (2 * (bits_xy - shift) + bits_z - shift)),
      arena.make_array<std::uint64_t>(kNames[level], count),
      arena.make_array<SurfelSums>(kNames[level], count),
      arena.make_array<Surfel>(kNames[level], count),
      arena.make_array<SurfelIndex>(kNames[level], count),
      arena.make_array<std::uint32_t>(kNames[level], count)};
  return {config_.cell_m * (1 << level), bits_xy - shift, bits_z - shift, config_.min_points,
          config_.memory_points,         memory};
}

ScanRegistration::ScanRegistration(const RegistrationConfig& config, rt::Arena& arena,
                                   std::uint32_t most_surfels, unsigned bits_xy, unsigned bits_z)
    : config_(config),
      layers_{make_layer(arena, 0, most_surfels, bits_xy, bits_z),
              make_layer(arena, 1, most_surfels, bits_xy, bits_z),
              make_layer(arena, 2, most_surfels, bits_xy, bits_z)},
      step_({arena.make_array<StepMemory::Slot>("match_slots", most_surfels),
             arena.make_array<CellSums>("match_cells", config.returns)}),
      chooser_(
          config.edge_m, config.min_range_m, config.max_range_m,
          arena.make_array<ScanSample::Slot>("sample_slots", std::bit_ceil(std::size_t{config.returns} * 8))),
      sample_(arena.make_array<SamplePoint>("sample", config.returns)),
      points_(arena.make_array<rt::Vector3>("map_points", kMostInserted)),
      cells_(arena.make_array<std::uint64_t>("map_cells", kMostInserted)) {}

std::size_t ScanRegistration::take(std::span<const rt::ScanPoint> scan) {
  size_ = chooser_.choose(scan, sample_, counts_);
  return size_;
}

/// Steps from coarse to fine. The sample's first returns are as good as any others: their order is by chance.
RigidPose ScanRegistration::descend(RigidPose pose, const PosePrior& prior, const Ladder& ladder,
                                    std::size_t returns, Match& match) {
  const std::span<const SamplePoint> sample = sample_.first(std::min(size_, returns));
  const auto steps = [&](int level, std::uint32_t count, double scale_m) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const NormalEquations equations =
          step_.equations(layers_[level], sample, pose, {scale_m, config_.sigma_m});
      if (!ScanStep::advance(equations, prior, pose)) return;
      ++match.steps;
    }
  };
  steps(2, ladder.coarse, 2.5 * config_.cell_m);
  steps(1, ladder.middle, 1.5 * config_.cell_m);
  steps(0, ladder.fine / 2, 0.75 * config_.cell_m);
  steps(0, ladder.fine - ladder.fine / 2, 0.25 * config_.cell_m);
  return pose;
}

/// Starts about a result, on each side along each of its six unknowns: a match that is a false minimum falls
/// into a better one from some of them. True when one did.
bool ScanRegistration::look_about(Match& match, const PosePrior& prior) {
  const std::span<const SamplePoint> few = sample_.first(std::min<std::size_t>(size_, 1024));
  double best = match_score(layers_[0], few, match.pose, config_.sigma_m).value * 1.02;
  RigidPose found = match.pose;
  bool better = false;
  for (int i = 0; i < 12; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    double by[6]{};
    by[i / 2] = side * (i < 6 ? 0.03 : 0.15);
    RigidPose pose{match.pose.p + rt::Vector3{by[3], by[4], by[5]},
                   rt::exp_rotation({by[0], by[1], by[2]}) * match.pose.q};
    for (int k = 0; k < 2; ++k) {
      const NormalEquations equations = step_.equations(layers_[0], few, pose, {0.15, config_.sigma_m});
      if (!ScanStep::advance(equations, prior, pose)) break;
      ++match.steps;
    }
    const double value = match_score(layers_[0], few, pose, config_.sigma_m).value;
    if (value > best) {
      best = value * 1.0;
      found = pose;
      better = true;
    }
  }
  if (better) match.pose = descend(found, prior, {0, 0, config_.steps}, size_, match);
  return better;
}

void ScanRegistration::recover(Match& match, const RigidPose& start, const RigidPose& other,
                               const PosePrior& prior) {
  struct Candidate {
    RigidPose pose;
    double value{-1.0};
  };
  Candidate best[3];
  const std::span<const SamplePoint> few = sample_.first(std::min(size_, kFewReturns));
  constexpr int kTurns = 5;  // either way
  for (const RigidPose* base : {&start, &other}) {
    for (int turn = -kTurns; turn <= kTurns; ++turn) {
      const RigidPose from{base->p,
                           rt::exp_rotation({0, 0, config_.recovery_turn_rad * turn / kTurns}) * base->q};
      Candidate candidate{descend(from, prior, {2, 2, 2}, kFewReturns, match)};
      candidate.value = match_score(layers_[0], few, candidate.pose, config_.sigma_m).value;
      for (Candidate& one : best) {
        if (candidate.value > one.value) std::swap(candidate, one);
      }
    }
  }
  match.recovered = true;
  MatchScore score = match.score;
  for (const Candidate& one : best) {
    const RigidPose pose = descend(one.pose, prior, {0, 1, config_.steps}, size_, match);
    const MatchScore reached = match_score(layers_[0], sample(), pose, config_.sigma_m);
    if (reached.value > score.value) {
      score = reached;
      match.pose = pose;
      match.other_start = true;
    }
  }
}

Match ScanRegistration::match(const RigidPose& start, const RigidPose& other, const PosePrior& prior) {
  Match match;
  match.pose = descend(start, prior, {2, 2, config_.steps}, size_, match);
  match.score = match_score(layers_[0], sample(), match.pose, config_.sigma_m);
  if (match.score.matched < config_.good_share) recover(match, start, other, prior);
  look_about(match, prior);
  match.score = match_score(layers_[0], sample(), match.pose, config_.sigma_m);
  match.equations =
      step_.equations(layers_[0], sample(), match.pose, {0.25 * config_.cell_m, config_.sigma_m});
  return match;
}

void ScanRegistration::insert(std::span<const rt::ScanPoint> scan, const RigidPose& pose) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  const double min2 = config_.min_range_m * config_.min_range_m;
  const double max2 = config_.max_range_m * config_.max_range_m;
  std::size_t n = 0;
  const std::size_t stride = 1 + scan.size() / (kMostInserted + 1);
  for (std::size_t i = 0; i < scan.size() && n < points_.size(); i += stride) {
    const rt::Vector3 v{scan[i].x_m, scan[i].y_m, scan[i].z_m};
    const double range2 = rt::dot(v, v);
    if (range2 >= min2 && range2 <= max2) points_[n++] = r * v + pose.p;
  }
  ++scans_;
  for (SurfelLayer& layer : layers_) {
    layer.evict_beyond(pose.p);
    layer.insert(points_.first(n), scans_, cells_);
  }
}

}  // namespace sortie::mapping
