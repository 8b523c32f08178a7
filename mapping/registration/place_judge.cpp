// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_judge.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/level_pose.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr std::size_t kLeastSample = 100;  ///< of a sample
constexpr double kPlaceMove = 0.5;         ///< m and rad: two places are two
constexpr double kPlaceTurn = 0.17;
/// The search takes places that are as good as each other half a metre up or down from where the robot is.
constexpr double kRises_m[] = {0.0, -0.25, 0.25, -0.5, 0.5};
/// What the attitude is worth, rad, against a scan's returns, which err together: while a place is found it
/// is what it is said to be, then it is known to half a degree.
constexpr double kHeldTilt = 0.0002;
}  // namespace

PosePrior PlaceJudge::prior_at(const RigidPose& pose, double tilt_rad) const {
  PosePrior prior;
  prior.at = {pose.p,
              rt::normalised(upright_turn(pose.q * rt::conjugate(q_level_sensor_)) * q_level_sensor_)};
  for (int i = 0; i < 6; ++i) prior.information[i][i] = 0.01;
  prior.information[0][0] = prior.information[1][1] = 1.0 / (tilt_rad * tilt_rad);
  return prior;
}

const char* to_string(RelocateVerdict verdict) {
  constexpr const char* kNames[] = {"none",      "searching",    "placed",
                                    "ambiguous", "nothing fits", "few returns"};
  const auto at = static_cast<std::size_t>(verdict);
  return at < std::size(kNames) ? kNames[at] : "unknown";
}

PlaceJudge::PlaceJudge(const RelocateConfig& config, ScanRegistration& registration, rt::Arena& arena)
    : config_(config),
      registration_(&registration),
      sample_(arena.make_array<SamplePoint>("judge_sample", registration.config().returns)),
      bits_(arena.make_array<std::uint64_t>(
          "judge_bits", std::size_t{3} * PlaceSearchConfig::kMostCandidates * ((sample_.size() + 63) / 64))),
      cubes_(arena.make_array<std::uint64_t>("judge_cubes", sample_.size())),
      weights_(arena.make_array<Weights>("judge_weights", sample_.size())) {}

bool PlaceJudge::begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor) {
  size_ = static_cast<std::uint32_t>(std::min(sample.size(), sample_.size()));
  std::copy_n(sample.begin(), size_, sample_.begin());
  q_level_sensor_ = rt::normalised(q_level_sensor);
  weigh_returns();
  at_ = count_ = 0;
  credit_.clear();
  units_ = 0;
  step_ = size_ < kLeastSample ? Step::idle : Step::tries;
  return step_ != Step::idle;
}

void PlaceJudge::add(const RigidPose& T_map_sensor) {
  if (count_ == PlaceSearchConfig::kMostCandidates) return;
  places_[count_] = {.pose = T_map_sensor, .slot = count_};
  ++count_;
}

bool PlaceJudge::pay(std::uint64_t cost, std::uint64_t& units) {
  if (!credit_.pay(cost, units)) return false;
  units_ += cost;
  return true;
}

bool PlaceJudge::run(std::uint64_t& units, JudgedPlace& judged) {
  if (step_ == Step::tries) {
    if (!run_tries(units)) return false;
    order();
    count_ = std::min(count_, kTried);
    at_ = 0;
    step_ = Step::retries;
  }
  if (step_ == Step::retries) {
    if (!run_retries(units)) return false;
    order();
    at_ = 0;
    step_ = Step::verdict;
  }
  if (step_ == Step::verdict) {
    if (!pay_looks(3 * std::size_t{size_}, units)) return false;
    judged = {};
    judged.verdict = judge(judged);
    step_ = Step::idle;
  }
  return true;
}

/// Its steps, and looking at what it explains.
bool PlaceJudge::pay_match(std::size_t returns, std::uint64_t& units) {
  return pay((registration_->config().steps + 8) * std::uint64_t{kMatchUnits} * returns, units);
}

/// A match, and what all rays say of where it ended.
bool PlaceJudge::pay_looks(std::size_t matched, std::uint64_t& units) {
  return pay((registration_->config().steps + 8) * std::uint64_t{kMatchUnits} * matched +
                 std::uint64_t{kRayUnits} * size_,
             units);
}

/// Each place from where it was said to be, with some of the returns.
bool PlaceJudge::run_tries(std::uint64_t& units) {
  const std::size_t returns = std::min<std::size_t>(size_, config_.first_returns);
  for (; at_ < count_; ++at_) {
    if (!pay_match(std::size(kRises_m) * returns, units)) return false;
    Place& place = places_[at_];
    registration_->take_sample(sample());
    Match best;
    for (const double rise_m : kRises_m) {
      const RigidPose start{place.pose.p + rt::Vector3{0, 0, rise_m}, place.pose.q};
      const Match match = registration_->match_from(start, prior_at(start, kHeldTilt), returns);
      if (rise_m == 0.0 || match.score.value > best.score.value) best = match;
    }
    keep(best, place);
  }
  return true;
}

/// Those that did well, with more returns, then with all; what does no better than it did before is left as
/// it was.
bool PlaceJudge::run_retries(std::uint64_t& units) {
  const std::size_t returns = std::min<std::size_t>(size_, config_.tried_returns);
  for (; at_ < count_; ++at_) {
    if (!pay_looks(3 * returns, units)) return false;
    Place& place = places_[at_];
    Place best = place;
    const auto take = [&] {
      if (place.explained >= best.explained) best = place;
      place = best;
    };
    match_place(place, returns);
    take();
    look_about(place, prior_at(place.pose, kFreeTilt));
    take();
    explain(place);
    look_along_rays(place);
  }
  return true;
}

/// From starts about where a place ended: a rival that was caught beside its place would be no rival.
Match PlaceJudge::look_about(Place& place, const PosePrior& prior) {
  Match match = registration_->match_from(place.pose, prior, size_);
  registration_->match_about(match, prior);
  keep(match, place);
  return match;
}

void PlaceJudge::match_place(Place& place, std::size_t returns) {
  registration_->take_sample(sample());
  keep(registration_->match_from(place.pose, prior_at(place.pose, kHeldTilt), returns), place);
}

void PlaceJudge::keep(const Match& match, Place& place) {
  place.pose = match.pose;
  place.weak = match.weak.moves + match.weak.turns > 0 || match.equations.rows < 6;
  explain(place);
}

/// Returns in one cube share one weight: of a surface in a cube as wide as the map's cells, in a level frame,
/// or of a thing in one four times as wide. What stands near the sensor has many returns.
void PlaceJudge::weigh_returns() {
  constexpr double kFarCubes = 30'000.0;
  constexpr std::uint32_t kWhole = 1 << 16;
  const rt::RotationMatrix r = rt::to_matrix(q_level_sensor_);
  for (std::size_t by = 0; by < kWeighed; ++by) {
    const double per_cube = 1.0 / (registration_->config().cell_m * (by == 0 ? 1.0 : 4.0));
    const auto cube = [&](double along_m) {
      const double at =
          std::max(-kFarCubes, std::min(kFarCubes, per_cube * along_m));  // what is no number, too
      return static_cast<std::uint64_t>(static_cast<std::uint16_t>(static_cast<std::int32_t>(rt::floor(at))));
    };
    for (std::uint32_t i = 0; i < size_; ++i) {
      const rt::Vector3 p = r * sample_[i].at();
      cubes_[i] = cube(p.x) << 48 | cube(p.y) << 32 | cube(p.z) << 16 | i;
    }
    std::sort(cubes_.data(), cubes_.data() + size_);
    std::uint64_t sum = 0;
    for (std::uint32_t from = 0, to = 0; from < size_; from = to) {
      while (to < size_ && cubes_[to] >> 16 == cubes_[from] >> 16) ++to;
      const std::uint32_t weight = kWhole / (to - from);
      for (std::uint32_t i = from; i < to; ++i) weights_[cubes_[i] & 0xffff].of[by] = weight;
      sum += std::uint64_t{to - from} * weight;
    }
    weight_[by] = static_cast<double>(sum);
  }
}

/// By explained returns, most first; one that ended where a better one did is left out.
void PlaceJudge::order() {
  std::sort(places_, places_ + count_, [](const Place& a, const Place& b) {
    return a.explained != b.explained ? a.explained > b.explained : a.slot < b.slot;
  });
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    bool other = true;
    for (std::uint32_t k = 0; k < kept; ++k)
      other = other && are_apart(places_[i].pose, places_[k].pose, kPlaceMove, kPlaceTurn);
    if (other) places_[kept++] = places_[i];
  }
  count_ = kept;
}

}  // namespace sortie::mapping
