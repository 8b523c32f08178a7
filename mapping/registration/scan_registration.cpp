// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/scan_registration.hpp"

#include <algorithm>
#include <bit>

namespace sortie::mapping {
namespace {
constexpr std::size_t kMostInserted = 8192;    ///< returns of a scan's sample: all of them go into the map
constexpr std::uint32_t kFewestSurfels = 256;  ///< of a layer
constexpr double kClearlyBetter = 1.02;        ///< of a score
constexpr double kAboutTurn = 0.03;            ///< rad and m from a result to the starts about it
constexpr double kAboutMove = 0.15;
/// Of the squares of where starts about a result end, two steps on: they are on their way still. With it the
/// errors on six shapes are those that the covariance says, or less.
constexpr double kOfSpread = 1.0 / 3.0;
constexpr double kNoiseMargin = 5.0;  ///< what holds a direction, against what noise could make of nothing
constexpr double kUsualDrop = 0.85;   ///< of the share of the scan before: less is a reason to look elsewhere
constexpr double kSaysNothing = 5.0;  ///< m: a prior that is no better

/// Whether the prior leaves metres open: there is no odometry.
bool says_nothing(const PosePrior& prior) {
  return prior.information[3][3] < 1.0 / (kSaysNothing * kSaysNothing);
}
}  // namespace

SurfelLayer ScanRegistration::make_layer(rt::Arena& arena, int level,
                                         const RegistrationMemory& memory) const {
  static constexpr const char* kNames[] = {"surfels_fine", "surfels_middle", "surfels_coarse"};
  const auto shift = static_cast<unsigned>(level);
  const unsigned bits_xy = window_bits(memory.window_cells) - shift;
  const unsigned bits_z = window_bits(memory.window_cells_up) - shift;
  // A quarter is flat, the rest is small.
  const std::uint32_t count = std::max(memory.surfels >> shift, kFewestSurfels);
  const SurfelLayerMemory arrays = surfel_memory(arena, kNames[level], kNames[level], bits_xy, bits_z, count);
  return {config_.cell_m * (1 << level), bits_xy, bits_z,        config_.min_points,
          config_.memory_points,         arrays,  config_.planar};
}

ScanRegistration::ScanRegistration(const RegistrationConfig& config, rt::Arena& arena,
                                   const RegistrationMemory& memory)
    : config_(config),
      layers_{make_layer(arena, 0, memory), make_layer(arena, 1, memory), make_layer(arena, 2, memory)},
      step_({arena.make_array<StepMemory::Slot>("match_slots", std::max(memory.surfels, kFewestSurfels)),
             arena.make_array<CellSums>("match_cells", config.returns)},
            config.planar),
      chooser_(config.edge_m, config.min_range_m, config.max_range_m,
               arena.make_array<ScanSample::Slot>(
                   "sample_slots", 4 * std::bit_ceil(std::max<std::size_t>(kMostInserted, config.returns)))),
      sample_(arena.make_array<SamplePoint>("sample", std::max<std::size_t>(kMostInserted, config.returns))),
      points_(arena.make_array<rt::Vector3>("map_points", sample_.size())),
      cells_(arena.make_array<std::uint64_t>("map_cells", sample_.size())) {}

std::size_t ScanRegistration::take(std::span<const rt::ScanPoint> scan) {
  chosen_ = chooser_.choose(scan, sample_, counts_);
  taken_ = true;
  size_ = std::min<std::size_t>(chosen_, config_.returns);
  return size_;
}

void ScanRegistration::lay_flat(const rt::Quaternion& tilt) {
  for (SamplePoint& point : sample_.first(chosen_)) {
    const rt::Vector3 v = rt::rotate(tilt, point.at());
    point = {static_cast<float>(v.x), static_cast<float>(v.y), 0.0f};
  }
}

std::size_t ScanRegistration::take_sample(std::span<const SamplePoint> sample) {
  taken_ = false;
  chosen_ = std::min(sample.size(), sample_.size());
  std::copy_n(sample.begin(), chosen_, sample_.begin());
  size_ = std::min<std::size_t>(chosen_, config_.returns);
  return size_;
}

/// Steps from coarse to fine. The sample's first returns are as good as any others: their order is by chance.
RigidPose ScanRegistration::descend(RigidPose pose, const PosePrior& prior, const Ladder& ladder,
                                    std::size_t returns, Match& match) {
  const std::span<const SamplePoint> sample = sample_.first(std::min(size_, returns));
  const auto steps = [&](int level, std::uint32_t count, double scale_m) {
    for (std::uint32_t i = 0; i < count; ++i) {
      NormalEquations equations = step_.equations(layers_[level], sample, pose,
                                                  {scale_m, config_.sigma_m, level == 0 && i == 0, false});
      if (level == 0) {
        if (i == 0) match.weak = weak_directions(equations, kNoiseMargin);
        let_go(match.weak, equations);
      }
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

/// Starts about a result, on each side along each of its unknowns. A match that is a false minimum falls
/// into a better one from some of them, and true is returned; where the pose is not held they stay apart, and
/// that is its uncertainty.
bool ScanRegistration::look_about(Match& match, const PosePrior& prior) {
  const std::span<const SamplePoint> few = sample_.first(std::min<std::size_t>(size_, 1024));
  const double value = match_score(layers_[0], few, match.pose, config_.sigma_m).value;
  double best = value * kClearlyBetter;
  RigidPose found = match.pose;
  bool better = false;
  const double starts = config_.planar ? 6.0 : 12.0;
  for (int i = 0; i < 12; ++i) {
    if (match.equations.holds(i / 2)) continue;
    double by[6]{};
    by[i / 2] = (i % 2 == 0 ? 1.0 : -1.0) * (i < 6 ? kAboutTurn : kAboutMove);
    RigidPose pose{match.pose.p + rt::Vector3{by[3], by[4], by[5]},
                   rt::exp_rotation({by[0], by[1], by[2]}) * match.pose.q};
    for (int k = 0; k < 2; ++k) {
      NormalEquations equations =
          step_.equations(layers_[0], few, pose, {0.15, config_.sigma_m, false, false});
      let_go(match.weak, equations);
      if (!ScanStep::advance(equations, prior, pose)) break;
      ++match.steps;
    }
    const double reached = match_score(layers_[0], few, pose, config_.sigma_m).value;
    if (reached > best) {
      best = reached;
      found = pose;
      better = true;
    }
    if (reached * kClearlyBetter < value) continue;
    const rt::Vector3 turned = rt::log_rotation(pose.q * rt::conjugate(match.pose.q));
    const rt::Vector3 moved = pose.p - match.pose.p;
    const double x[6] = {turned.x, turned.y, turned.z, moved.x, moved.y, moved.z};
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column)
        match.spread[row][column] += x[row] * x[column] * kOfSpread / starts;
    }
  }
  if (!better) return false;
  const WeakDirections weak = match.weak;
  found = descend(found, prior, {0, 0, config_.steps}, size_, match);
  const MatchScore score = match_score(layers_[0], sample(), found, config_.sigma_m);
  match.weak = weak;
  if (score.value <= match.score.value) return false;
  match.pose = found;
  return true;
}

/// The equations at the pose, and what they do not hold.
void ScanRegistration::weigh(Match& match) {
  match.equations =
      step_.equations(layers_[0], sample(), match.pose,
                      {0.25 * config_.cell_m, config_.sigma_m, true, match.alone && !config_.planar});
  match.weak = weak_directions(match.equations, kNoiseMargin);
}

Match ScanRegistration::match(const RigidPose& start, const RigidPose& other, const PosePrior& prior,
                              double usual_share) {
  Match match;
  const auto good = [&] {
    return match.score.matched >= config_.good_share * match.score.known &&
           match.score.matched >= kUsualDrop * usual_share;
  };
  const auto take = [&](const RigidPose& pose) {
    const MatchScore score = match_score(layers_[0], sample(), pose, config_.sigma_m);
    if (score.value <= match.score.value) return;
    match.pose = pose;
    match.score = score;
  };
  // The coarse layers reach farther, and are led astray where the map is thin: only where a good start did
  // not do.
  match.alone = says_nothing(prior);
  match.pose = start;
  match.score = match_score(layers_[0], sample(), start, config_.sigma_m);
  take(descend(start, prior, {0, 0, config_.steps}, size_, match));
  if (!good()) take(descend(start, prior, {2, 2, config_.steps}, size_, match));
  weigh(match);  // descending left the weak directions of the last start that was tried
  if (!good()) {
    recover(match, start, other, prior);
    match.score = match_score(layers_[0], sample(), match.pose, config_.sigma_m);
    weigh(match);
  }
  if (match.alone) look_for_rivals(match, prior);
  match_about(match, prior);
  return match;
}

void ScanRegistration::match_about(Match& match, const PosePrior& prior) {
  if (!look_about(match, prior)) return;
  match.score = match_score(layers_[0], sample(), match.pose, config_.sigma_m);
  weigh(match);
}

Match ScanRegistration::match_from(const RigidPose& start, const PosePrior& prior, std::size_t returns) {
  const std::span<const SamplePoint> some = sample().first(std::min(size_, returns));
  Match match;
  match.pose = descend(start, prior, {0, 0, config_.steps}, returns, match);
  match.score = match_score(layers_[0], some, match.pose, config_.sigma_m);
  if (match.score.matched < config_.good_share) {
    const RigidPose other = descend(start, prior, {2, 2, config_.steps}, returns, match);
    const MatchScore score = match_score(layers_[0], some, other, config_.sigma_m);
    if (score.value > match.score.value) {
      match.pose = other;
      match.score = score;
    }
  }
  weigh(match);
  return match;
}

void ScanRegistration::insert(const RigidPose& pose) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  for (std::size_t i = 0; i < chosen_; ++i) points_[i] = r * sample_[i].at() + pose.p;
  ++scans_;
  for (SurfelLayer& layer : layers_) {
    layer.evict_beyond(pose.p);
    layer.insert(points_.first(chosen_), pose.p, scans_, cells_);
  }
}

void ScanRegistration::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "scan registration")
      .fixed(config_)
      .by_hand(layers_)
      .scratch(step_, chooser_, sample_, points_, cells_, chosen_, size_, taken_)
      .state(scans_, counts_);
  for (SurfelLayer& layer : layers_) archive.value(layer);
}

}  // namespace sortie::mapping
