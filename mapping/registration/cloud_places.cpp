// SPDX-License-Identifier: BSD-3-Clause
// Places that are fitted, looked at and compared. What leads there is in cloud_registration.cpp.
#include <algorithm>
#include <bit>
#include <cmath>

#include "mapping/registration/cloud_registration.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr int kQuickSteps = 5;             ///< of a fit, fewer than kFitSteps
constexpr std::uint32_t kQuickStride = 3;  ///< of the cells of a quick one
constexpr std::uint32_t kRounds = 2;       ///< of looking about a start
constexpr double kAbout_m[8] = {-1.6, -1.2, -0.8, -0.4, 0.4, 0.8, 1.2, 1.6};
constexpr double kHeld_m[8] = {-1.5, -0.9, -0.5, -0.3, 0.3, 0.5, 0.9, 1.5};
constexpr std::uint32_t kShifts = 3 * 8;
constexpr double kAgainst = 3.0;  ///< a line of sight through a surface, in cells that do not lie on one
constexpr double kWorthLooking = 0.85;  ///< of the start's pairs: what a neighbour's fit must have
constexpr double kBetter = 1.02;        ///< and by three: what a neighbour must be to be gone to
constexpr double kChance = 5.0;         ///< cells that may speak for any place
constexpr double kContender = 0.25;     ///< of the best place's cells on surfaces
constexpr double kLeastUsual = 0.008;  ///< lines of sight through surfaces a cell on them, where all is right
constexpr double kMostUsual = 0.016;
constexpr double kMostSigmas = 3.0;  ///< of the scale from the estimate's
constexpr double kBasin_m = 0.15;    ///< a fit of cells may go so far
constexpr double kBasin_rad = 0.03;
}  // namespace

double CloudRegistration::Place::value() const { return on - kAgainst * through; }

void CloudRegistration::look(const PlanePose& pose, Place& place) {
  ++result_.looks;
  place.pose = pose;
  place.mirrored = in_mirror();
  place.pairs = fitted_pairs_;
  std::span<const SightCell> target = target_cells();
  PlanePose back = pose;
  if (place.mirrored) {  // the source stays as it is, and the target is seen in the mirror
    const rt::Vector3 axis = rt::rotate(pose.q_target_source, mirror_);
    back.p_target_source_m = mirrored(pose.p_target_source_m, axis);
    for (std::uint32_t i = 0; i < target_count_; ++i) scratch_[i] = mirrored(target[i], axis);
    target = {scratch_, target_count_};
  }
  const auto bits = [&place](std::uint32_t first) {
    return SightBits{{place.on_bits + first, kWords},
                     {place.off_bits + first, kWords},
                     {place.through_bits + first, kWords}};
  };
  const SightCount there = count_sights(source_cells(), *target_, pose, config_.gates, bits(0));
  const SightCount here = count_sights(target, *source_, inverse(back), config_.gates, bits(kWords));
  place.on = there.on + here.on;
  place.through = there.through + here.through;
}

PlanePose CloudRegistration::shifted(const PlanePose& pose, std::uint32_t k, const double (&by_m)[8]) const {
  PlanePose out = pose;
  out.p_target_source_m = out.p_target_source_m + by_m[k % 8] * axis_[k / 8];
  return out;
}

/// One fit: of the start itself, of one of its neighbours, or of the best of these once more.
void CloudRegistration::fit() {
  ++result_.fits;
  const bool rival = pass_ > 0;
  const bool quick = rival || (shift_ > 0 && shift_ <= kShifts);
  const PlanePose from = shift_ == 0 ? starts_[start_]
                         : quick     ? shifted(here_.pose, shift_ - 1, kAbout_m)
                                     : ahead_.pose;
  const SightFit fit = fit_sights(source_cells(), *target_, from, estimate_, config_.gates,
                                  quick ? kQuickSteps : kFitSteps, quick ? kQuickStride : 1);
  fitted_ = fit.T_target_source;
  if (rival && kQuickStride * fit.pairs < kContender * places_[best_].pairs) return end_start();
  if (quick && !rival && kQuickStride * fit.pairs < kWorthLooking * here_.pairs) {
    ++shift_;
    return;
  }
  fitted_pairs_ = quick ? kQuickStride * fit.pairs : fit.pairs;
  stage_ = Stage::look;
}

/// One look at what was fitted. Only what planes led to is looked about.
void CloudRegistration::settle() {
  stage_ = Stage::fit;
  if (shift_ == 0) {
    look(fitted_, here_);
    ahead_ = here_;
    if (pass_ > 0) {
      if (contends(here_) || here_.value() > places_[best_].value()) keep_place();
      return end_start();
    }
    shift_ = 1;
    return;
  }
  look(fitted_, look_);
  if (shift_ <= kShifts) {
    if (look_.value() > kBetter * ahead_.value() + 3.0) ahead_ = look_;
    ++shift_;
    return;
  }
  const bool better = look_.value() > kBetter * here_.value() + 3.0;
  if (look_.value() > here_.value()) here_ = look_;
  ahead_ = here_;
  shift_ = 1;
  if (better && ++round_ < kRounds) return;
  keep_place();
  end_start();
}

/// Of the same place the better one stays.
void CloudRegistration::keep_place() {
  for (std::uint32_t k = 0; k < place_count_; ++k) {
    Place& known = places_[k];
    if (known.mirrored != here_.mirrored ||
        !same_place(known.pose, here_.pose, middle_m_, kBasin_m, kBasin_rad))
      continue;
    if (here_.value() > known.value()) known = here_;
    return;
  }
  if (place_count_ == kMostPlaces)
    ++result_.dropped;
  else
    places_[place_count_++] = here_;
}

void CloudRegistration::end_start() {
  ++result_.places;
  round_ = shift_ = 0;
  if (++start_ == starts_.size()) end_pass();
}

void CloudRegistration::end_pass() {
  best_ = 0;
  for (std::uint32_t k = 1; k < place_count_; ++k) {
    if (!places_[k].mirrored && places_[k].value() > places_[best_].value()) best_ = k;
  }
  if (place_count_ == 0) {
    stage_ = Stage::done;
    result_.verdict = CloudVerdict::refused;
    result_.refusal = CloudRefusal::no_place;
    return;
  }
  if (next_pass()) return;
  pass_ = 0;
  const SightFit fit =
      fit_sights(source_cells(), *target_, places_[best_].pose, estimate_, config_.gates, kFitSteps, 1);
  result_.sigma_m = fit.sigma_m;
  result_.sigma_rad = fit.sigma_rad;
  result_.lead = 1e9;
  for (std::uint32_t k = 0; k < place_count_; ++k) {
    if (k != best_ && contends(places_[k])) compare(places_[best_], places_[k], true);
  }
  shift_ = 0;
  stage_ = Stage::hold;
}

/// One look at a neighbour of the best place: where that is as good, nothing holds the best one there.
void CloudRegistration::hold() {
  look(shifted(places_[best_].pose, shift_, kHeld_m), look_);
  compare(places_[best_], look_, false);
  if (++shift_ < kShifts) return;
  stage_ = Stage::done;
  judge();
}

/// A place that little speaks against. What the clouds have in common there may be less than at the best one,
/// and how many lines of sight go through surfaces where all is right depends on the building: the best place
/// says.
bool CloudRegistration::contends(const Place& place) const {
  const Place& best = places_[best_];
  const double usual =
      std::clamp(static_cast<double>(best.through) / std::max(1u, best.on), kLeastUsual, kMostUsual);
  return place.on >= std::max(static_cast<double>(config_.least_on), kContender * best.on) &&
         place.through <= 3.0 * usual * place.on + 3.0;
}

/// `apart`: what the other place says nothing about does not speak against it; of a neighbour it does.
void CloudRegistration::compare(const Place& best, const Place& other, bool apart) {
  const auto count = [](std::uint64_t bits) { return static_cast<std::uint32_t>(std::popcount(bits)); };
  std::uint32_t here = 0, there = 0, against_other = 0, against_best = 0;
  for (std::uint32_t i = 0; i < 2 * kWords; ++i) {
    here += count(best.on_bits[i] & (apart ? other.off_bits[i] : ~other.on_bits[i]));
    there += count(other.on_bits[i] & ~best.on_bits[i]);
    against_other += count(other.through_bits[i] & ~best.through_bits[i]);
    against_best += count(best.through_bits[i] & ~other.through_bits[i]);
  }
  const double lead = (here + kAgainst * against_other) / (there + kAgainst * against_best + kChance);
  if (lead >= result_.lead) return;
  result_.lead = lead;
  result_.T_rival = other.pose;
  result_.rival_mirrored = other.mirrored;
}

void CloudRegistration::judge() {
  const Place& best = places_[best_];
  result_.T_target_source = best.pose;
  result_.on = best.on;
  result_.through = best.through;
  result_.verdict = CloudVerdict::refused;
  if (best.on < config_.least_on) {
    result_.refusal = CloudRefusal::little;
  } else if (best.through > config_.most_through * result_.cells) {
    result_.refusal = CloudRefusal::crossed;
  } else if (std::fabs(rt::log(best.pose.scale / estimate_.T_target_source.scale)) >
             kMostSigmas * estimate_.sigma_scale) {
    result_.refusal = CloudRefusal::scale;
  } else if (result_.lead < config_.least_lead || result_.dropped > 0) {
    result_.verdict = CloudVerdict::ambiguous;
    result_.refusal = result_.rival_mirrored ? CloudRefusal::mirrored : CloudRefusal::rival;
  } else if (!(result_.sigma_m < config_.most_sigma_m && result_.sigma_rad < config_.most_sigma_rad)) {
    result_.refusal = CloudRefusal::unheld;
  } else if (!estimate_.has_yaw() &&
             !(planes_result_.placed() &&
               same_place(planes_result_.fit.T_target_source, best.pose, middle_m_, kBasin_m, kBasin_rad))) {
    result_.verdict = CloudVerdict::ambiguous;
    result_.refusal = CloudRefusal::turn;
  } else {
    result_.verdict = CloudVerdict::placed;
  }
}

}  // namespace sortie::mapping
