// SPDX-License-Identifier: BSD-3-Clause
// Places that are looked at, fitted and kept. What leads there is in plane_registration.cpp.
#include <algorithm>

#include "mapping/registration/plane_registration.hpp"

namespace sortie::mapping {
namespace {
constexpr double kSlack = 3.0;    ///< of evidence, that a second fit may add
constexpr double kClearly = 0.5;  ///< what is looked at without a fit must be clear
constexpr double kKernelSigmas = 5.0;
}  // namespace

/// Evidence of a place that neither could be the best one nor speaks against it. Without what both have in
/// common the best one has a at most its evidence, the other b; a - b is the difference of their evidence.
double PlaneRegistration::harmless() const {
  if (fitted_count_ == 0) return -1e9;
  const double best = fitted_[order_[0]].evidence;
  return std::min(config_.most_runner_up * best, best - config_.least_margin);
}

/// What a place must promise to be worth a look: it could be the best one, or a runner-up that counts.
double PlaneRegistration::least_gain() const {
  double least = log_places_ + std::max(0.0, harmless());
  least = std::max(least, 0.5 * best_look_);
  if (places_.full()) least = std::max(least, places_.back().gain);
  return least;
}

/// What the combination of peaks at_ promises, step by step less and dearer, until it is not worth a look:
/// then how many axes may go on at once. Peaks are sorted: what the first of them cannot promise, those
/// behind it cannot either.
std::uint32_t PlaneRegistration::hopeless_axes(double least) {
  constexpr std::uint32_t kWorthALook = 0;
  const std::uint32_t axes = candidates_.axes();
  double promised = candidates_.rest_gain();
  for (std::uint32_t a = 0; a < axes; ++a) promised += candidates_.axis(a).peaks[at_[a]].gain;
  if (promised <= least) {
    std::uint32_t moved = 0;
    while (moved < axes && at_[moved] == 0) ++moved;
    return std::min(moved + 2, axes + 1);
  }
  if (axes < 3) return kWorthALook;
  const auto given = [this](std::uint32_t a, std::uint32_t b) {
    return candidates_.gain_given(a, at_[a], b, at_[b]);
  };
  // Without the first axis: the same for all of its peaks.
  const double second = given(1, 2);
  const double third = given(2, 1);
  double first = candidates_.axis(0).peaks[at_[0]].gain;
  if (candidates_.rest_gain() + first + second + third <= least) return 2;
  first = std::min(given(0, 1), given(0, 2));
  const double all =
      candidates_.rest_gain() + first + std::min(second, given(1, 0)) + std::min(third, given(2, 0));
  return all <= least ? 1 : kWorthALook;
}

/// Goes through some combinations of peaks, or to the first that is looked at.
void PlaneRegistration::look() {
  const std::uint32_t axes = candidates_.axes();
  bool looked = false;
  for (int tries = 0; tries < 16 && !looked; ++tries) {
    const double least = least_gain();
    std::uint32_t moved = hopeless_axes(least);
    if (moved == 0 && result_.hypotheses == kMostHypotheses) {
      ++result_.dropped;
      moved = axes + 1;
    }
    looked = moved == 0;
    if (looked) look_at_place(least);
    moved = moved == 0 ? 0 : moved - 1;  // peaks of so many axes begin anew
    for (std::uint32_t a = 0; a < moved && a < axes; ++a) at_[a] = 0;
    while (moved < axes) {
      if (++at_[moved] < candidates_.axis(moved).peaks.size()) break;
      at_[moved++] = 0;
    }
    if (moved >= axes) {
      stage_ = places_.empty() ? Stage::scale : Stage::fit;
      return;
    }
  }
}

void PlaneRegistration::look_at_place(double least) {
  ++result_.hypotheses;
  double along[3]{};
  double promised = candidates_.rest_gain();
  std::uint32_t planes = candidates_.rest_planes();
  for (std::uint32_t a = 0; a < candidates_.axes(); ++a) {
    const ShiftPeak& peak = candidates_.axis(a).peaks[at_[a]];
    along[a] = peak.at_m;
    promised += peak.gain;
    planes += peak.planes;
  }
  const rt::Vector3 t_m = candidates_.shift(along);
  // With so many misses it is not worth it.
  const auto enough = planes + 1 + static_cast<std::uint32_t>((promised - least) / miss_cost_);
  const std::uint32_t covered = candidates_.covered_at(t_m, enough);
  if (covered >= enough) return;
  const auto cost = [&](std::uint32_t matched) {
    return covered > matched ? miss_cost_ * (covered - matched) : 0.0;
  };
  const ShiftLook found = candidates_.look_at(t_m, at_, least + cost(planes));
  if (!found.whole) return;
  Place place{t_m, found.gain - cost(found.matched), {}, {}, found.matched};
  for (int a = 0; a < 3; ++a) place.of_axis[a] = found.of_axis[a], place.peak[a] = at_[a];
  best_look_ = std::max(best_look_, place.gain);
  keep_place(place);
}

/// A place of the same rotation and scale as the best one has in common with it what lies on the same peaks:
/// only the other axes tell them apart, and there the best one's own gain is known.
bool PlaneRegistration::harmless(const Place& place) const {
  if (place.gain - log_places_ <= harmless()) return true;
  if (fitted_count_ == 0 || in_mirror_) return false;
  const Fitted& best = fitted_[order_[0]];
  if (best.search != search_ || place.gain - log_places_ > best.evidence) return false;
  double a = 0.0;
  double b = 0.0;
  for (std::uint32_t k = 0; k < candidates_.axes(); ++k) {
    if (place.peak[k] == best.peak[k]) continue;
    a += best.of_axis[k];
    b += place.of_axis[k];
  }
  return b <= kClearly * config_.most_runner_up * a && a - b >= config_.least_margin / kClearly;
}

void PlaneRegistration::keep_place(const Place& place) {
  if (!(place.gain > least_gain())) return;
  for (std::uint32_t k = 0; k < places_.size(); ++k) {
    if (rt::norm(places_[k].t_m - place.t_m) > config_.basin_m) continue;
    if (places_[k].gain >= place.gain) return;
    places_.erase(k);
    break;
  }
  if (places_.full()) places_.pop_back();
  std::uint32_t at = places_.size();
  (void)places_.push_back(place);
  for (; at > 0 && places_[at - 1].gain < place.gain; --at) places_[at] = places_[at - 1];
  places_[at] = place;
}

void PlaneRegistration::fit_next() {
  const Place place = places_[place_];
  if (++place_ == places_.size()) stage_ = Stage::scale;
  if (harmless(place)) return;
  ++result_.fits;
  // What is only near takes part in a first fit, which outliers must not pull; then what agrees.
  PlaneFitConfig first = config_.fit;
  first.kernel_sigmas = kKernelSigmas;
  first.observed_sigma_m = std::max(config_.fit.observed_sigma_m, config_.search_gate_m);
  first.observed_sigma_rad = std::max(config_.fit.observed_sigma_rad, config_.most_angle_rad);
  PlanePose pose = candidates_.pose(place.t_m);
  Fitted& f = fresh_;
  pair_near(side(), target_, candidates_, pose, config_, near_, f.pairs);
  for (int round = 0; round < 2; ++round) {
    if (f.pairs.empty()) return;
    f.fit = fit_planes(side().planes(), target_.planes(), {f.pairs.data(), f.pairs.size()}, pose, estimate_,
                       round == 0 ? first : config_.fit, 2);
    if (!f.fit.finite) return;
    pose = f.fit.T_target_source;
    f.consensus = judge(side(), target_, candidates_, near_, pose, config_, f.pairs, f.gain);
    if (f.consensus.evidence - log_places_ <= harmless() - kSlack) return;
  }
  f.evidence = f.consensus.evidence - log_places_;
  f.search = search_;
  for (std::uint32_t a = 0; a < 3; ++a) {
    f.peak[a] = place.peak[a];
    f.of_axis[a] = 0.0;
    if (a >= candidates_.axes()) continue;
    for (std::uint32_t i = 0; i < f.pairs.size(); ++i) {
      if (target_.family(f.pairs[i].target) == candidates_.axis(a).family) f.of_axis[a] += f.gain[i];
    }
  }
  if (in_mirror_)
    mirror_rivalry_ = std::max(mirror_rivalry_, rivalry(fitted_[order_[0]], f, 0.0));
  else
    keep();
}

/// Puts the fresh place among the fitted ones: instead of a lesser one in the same basin, or of the least.
void PlaneRegistration::keep() {
  std::uint32_t at = fitted_count_;
  for (std::uint32_t k = 0; k < fitted_count_; ++k) {
    const Fitted& other = fitted_[order_[k]];
    if (!same_place(fresh_.fit.T_target_source, other.fit.T_target_source, source_.middle_m(),
                    config_.basin_m, config_.basin_rad))
      continue;
    if (other.evidence >= fresh_.evidence) return;
    at = k;
    break;
  }
  if (at == kMostFitted) {
    if (fitted_[order_[--at]].evidence >= fresh_.evidence) return;
  } else if (at == fitted_count_) {
    order_[at] = static_cast<std::uint8_t>(fitted_count_++);
  }
  const std::uint8_t slot = order_[at];
  fitted_[slot] = fresh_;
  for (; at > 0 && fitted_[order_[at - 1]].evidence < fresh_.evidence; --at) order_[at] = order_[at - 1];
  order_[at] = slot;
}

/// Evidence of the other place over the best one's, without pairs that both have.
double PlaneRegistration::rivalry(const Fitted& best, const Fitted& other, double least_margin) const {
  double shared_of_best = 0.0;
  double shared_of_other = 0.0;
  std::uint32_t k = 0;  // pairs are in the order of source planes
  for (std::uint32_t i = 0; i < best.pairs.size(); ++i) {
    while (k < other.pairs.size() && other.pairs[k].source < best.pairs[i].source) ++k;
    if (k == other.pairs.size()) break;
    if (other.pairs[k].source != best.pairs[i].source || other.pairs[k].target != best.pairs[i].target)
      continue;
    shared_of_best += best.gain[i];
    shared_of_other += other.gain[k];
  }
  const auto own = [](const Fitted& f, double shared) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < f.pairs.size(); ++i) sum += f.gain[i];
    return std::max(0.0, sum - shared);
  };
  const double a = own(best, shared_of_best);
  const double b = own(other, shared_of_other);
  if (a - b < least_margin) return std::max(1.0, b / std::max(a, 1e-9));
  return b / std::max(a, 1e-9);
}

}  // namespace sortie::mapping
