// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_registration.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kSlack = 3.0;    ///< of evidence, that a second fit may add
constexpr double kClearly = 0.5;  ///< what is looked at without a fit must be clear
constexpr double kKernelSigmas = 5.0;
constexpr std::uint64_t kFitUnits = 100;  ///< a matched pair in two fits and two looks

bool good(const PlaneEstimate& e) {
  const double sigmas[] = {e.sigma_position_m, e.sigma_yaw_rad, e.sigma_tilt_rad, e.sigma_scale};
  for (const double s : sigmas) {
    if (!(s >= 0.0 && s <= kMostPlaneSigma)) return false;
  }
  const rt::Vector3& p = e.T_target_source.p_target_source_m;
  const double squared = rt::squared_norm(e.T_target_source.q_target_source);
  return std::fabs(p.x) <= kMostPlaneCoordinate_m && std::fabs(p.y) <= kMostPlaneCoordinate_m &&
         std::fabs(p.z) <= kMostPlaneCoordinate_m && squared > 1.0 - 1e-6 && squared < 1.0 + 1e-6 &&
         e.T_target_source.scale >= 0.01 && e.T_target_source.scale <= 100.0;
}

bool finite(const PlaneEstimate& e) {
  const PlanePose& pose = e.T_target_source;
  bool all = rt::is_finite(pose.q_target_source) && rt::is_finite(pose.p_target_source_m);
  for (const double v : {pose.scale, e.sigma_position_m, e.sigma_yaw_rad, e.sigma_tilt_rad, e.sigma_scale})
    all = all && std::isfinite(v);
  return all;
}
}  // namespace

PlaneRegistration::PlaneRegistration(const PlaneRegistrationConfig& config)
    : config_(config), miss_cost_(-rt::log(1.0 - config.share_matched)) {}

Status PlaneRegistration::begin(const PlaneSet& source, const PlaneSet& target,
                                const PlaneEstimate& estimate) {
  stage_ = Stage::done;
  result_ = {};
  best_pairs_.clear();
  fitted_count_ = 0;
  best_look_ = 0.0;
  search_ = 0;
  best_scale_ = false;
  mirror_ = 0;
  in_mirror_ = false;
  mirror_rivalry_ = 0.0;
  credit_ = 0;
  bad_plane_ = 0;
  if (!finite(estimate)) return Status::not_finite;
  if (!good(estimate)) return Status::out_of_range;
  Status status = check(source, bad_plane_);
  if (status != Status::ok) return status;
  status = check(target, bad_plane_);
  bad_plane_ += 1000;
  if (status != Status::ok) return status;
  bad_plane_ = 0;
  estimate_ = estimate;
  if (source.empty() || target.empty()) {
    result_.verdict = PlaneVerdict::refused;
    result_.refusal = PlaneRefusal::no_planes;
    return Status::ok;
  }
  source_.take(source);
  target_.take(target);
  result_.verdict = PlaneVerdict::working;
  stage_ = Stage::turns;
  return Status::ok;
}

std::uint64_t PlaneRegistration::next_cost() const {
  const std::uint64_t all = std::uint64_t{source_.size()} * target_.size();
  switch (stage_) {
    case Stage::turns:
      return estimate_.has_gravity() ? all : all + 60000;
    case Stage::pair:
    case Stage::mirror:
      return all;
    case Stage::scale:
      return 4 * candidates_.size() + 100 + (estimate_.wants_scale() ? 2000 : 0);
    case Stage::look:
      return 40;
    case Stage::fit:
      return 2 * candidates_.size() + kFitUnits * std::max(4u, places_[place_].matched);
    default:
      return 1;
  }
}

bool PlaneRegistration::run(std::uint64_t& units) {
  while (stage_ != Stage::done) {
    const std::uint64_t cost = next_cost();
    if (units + credit_ < cost) {
      credit_ += units;
      units = 0;
      return false;
    }
    const std::uint64_t from_credit = std::min(credit_, cost);
    credit_ -= from_credit;
    units -= cost - from_credit;
    result_.units += cost;
    step();
  }
  return true;
}

void PlaneRegistration::step() {
  switch (stage_) {
    case Stage::turns:
      find_turns(source_, target_, estimate_, config_, turns_);
      result_.turns = turns_.size();
      turn_ = 0;
      stage_ = Stage::pair;
      break;
    case Stage::pair:
      begin_turn();
      break;
    case Stage::scale:
      begin_scale();
      break;
    case Stage::look:
      look();
      break;
    case Stage::fit:
      fit_next();
      break;
    case Stage::mirror:
      begin_mirror();
      break;
    default:
      finish();
  }
}

/// Mirror images of the source, as the best place has it turned, about its middle along the two axes that lie
/// flattest: where one of them fits better the place may be the mirror image of the right one.
void PlaneRegistration::begin_mirror() {
  in_mirror_ = false;
  if (fitted_count_ == 0 || mirror_ == 2) {
    stage_ = Stage::judge;
    return;
  }
  const PlanePose& pose = fitted_[order_[0]].fit.T_target_source;
  if (mirror_ == 0) {
    candidates_.pair_up(source_, target_, pose.q_target_source, config_);
    rt::Vector3 axis[3];
    std::uint32_t count = 0;
    for (; count < candidates_.axes(); ++count) axis[count] = candidates_.axis(count).axis;
    std::sort(axis, axis + count,
              [](const rt::Vector3& a, const rt::Vector3& b) { return std::fabs(a.z) < std::fabs(b.z); });
    mirrors_.clear();
    for (std::uint32_t k = 0; k < count && k < 2; ++k) (void)mirrors_.push_back(axis[k]);
  }
  if (mirror_ >= mirrors_.size()) {
    stage_ = Stage::judge;
    return;
  }
  in_mirror_ = true;
  image_.mirror(source_, rt::rotate_back(pose.q_target_source, mirrors_[mirror_]));
  ++mirror_;
  candidates_.pair_up(image_, target_, pose.q_target_source, config_);
  scales_.clear();
  (void)scales_.push_back(pose.scale);
  scale_ = 0;
  stage_ = Stage::scale;
}

void PlaneRegistration::begin_turn() {
  if (turn_ == turns_.size() && estimate_.wants_scale() && fitted_count_ > 0 && !best_scale_) {
    best_scale_ = true;  // once more all rotations, with the scale that was best under one of them
    turn_ = 0;
  }
  if (turn_ == turns_.size()) {
    stage_ = Stage::mirror;
    return;
  }
  candidates_.pair_up(source_, target_, turns_[turn_].q_target_source, config_);
  result_.dropped += candidates_.dropped();
  ++turn_;
  scales_.clear();
  if (!estimate_.wants_scale()) (void)scales_.push_back(estimate_.T_target_source.scale);
  if (best_scale_) (void)scales_.push_back(fitted_[order_[0]].fit.T_target_source.scale);
  scale_ = 0;
  stage_ = Stage::scale;
}

void PlaneRegistration::begin_scale() {
  if (scales_.empty()) candidates_.find_scales(estimate_, scales_);
  if (scale_ == scales_.size() || candidates_.axes() == 0) {
    stage_ = in_mirror_ ? Stage::mirror : Stage::pair;
    return;
  }
  candidates_.find_shifts(scales_[scale_], estimate_, config_);
  ++search_;
  ++scale_;
  places_.clear();
  place_ = 0;
  at_[0] = at_[1] = at_[2] = 0;
  double places = static_cast<double>(turns_.size()) * (estimate_.wants_scale() ? 6.0 : 1.0);
  bool some = true;
  for (std::uint32_t a = 0; a < candidates_.axes(); ++a) {
    places *= std::max(1u, candidates_.axis(a).pairs);
    some = some && !candidates_.axis(a).peaks.empty();
  }
  log_places_ = rt::log(places);
  stage_ = some ? Stage::look : Stage::scale;
}

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

bool PlaneRegistration::same_basin(const PlanePose& a, const PlanePose& b) const {
  const rt::Vector3 apart = transform(a, source_.middle_m()) - transform(b, source_.middle_m());
  const rt::Vector3 turn = rt::log_rotation(a.q_target_source * rt::conjugate(b.q_target_source));
  return rt::norm(apart) <= config_.basin_m && rt::norm(turn) <= config_.basin_rad;
}

/// Puts the fresh place among the fitted ones: instead of a lesser one in the same basin, or of the least.
void PlaneRegistration::keep() {
  std::uint32_t at = fitted_count_;
  for (std::uint32_t k = 0; k < fitted_count_; ++k) {
    const Fitted& other = fitted_[order_[k]];
    if (!same_basin(fresh_.fit.T_target_source, other.fit.T_target_source)) continue;
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

void PlaneRegistration::finish() {
  stage_ = Stage::done;
  const auto refuse = [this](PlaneRefusal why) {
    result_.verdict = why == PlaneRefusal::runner_up || why == PlaneRefusal::mirrored
                          ? PlaneVerdict::ambiguous
                          : PlaneVerdict::refused;
    result_.refusal = why;
  };
  if (fitted_count_ == 0) return refuse(PlaneRefusal::few_matches);
  const Fitted& best = fitted_[order_[0]];
  result_.fit = best.fit;
  result_.evidence = best.evidence;
  result_.matched = best.consensus.matched;
  result_.share = best.consensus.share();
  for (PlanePair pair : best.pairs)
    (void)best_pairs_.push_back({source_.given(pair.source), target_.given(pair.target), pair.opposite});
  for (std::uint32_t k = 1; k < fitted_count_; ++k) {
    const double rival = rivalry(best, fitted_[order_[k]], config_.least_margin);
    if (k > 1 && rival <= result_.rivalry) continue;
    result_.rivalry = rival;
    result_.runner_up_evidence = fitted_[order_[k]].evidence;
    result_.T_runner_up = fitted_[order_[k]].fit.T_target_source;
  }
  result_.mirror_rivalry = mirror_rivalry_;
  const bool whole_turn = best.fit.rotation_rank == 3;
  const bool whole_shift = best.fit.translation_rank == (estimate_.wants_scale() ? 4 : 3);
  if (result_.matched < config_.least_matches) return refuse(PlaneRefusal::few_matches);
  if (result_.share < config_.least_share) return refuse(PlaneRefusal::little_share);
  const double expected = std::max(1u, best.consensus.expected);
  if (result_.evidence < std::max(config_.least_evidence, config_.evidence_per_plane * expected))
    return refuse(PlaneRefusal::little_evidence);
  if (result_.rivalry > config_.most_runner_up) return refuse(PlaneRefusal::runner_up);
  if (result_.mirror_rivalry > config_.most_mirrored) return refuse(PlaneRefusal::mirrored);
  if ((!whole_turn && !estimate_.has_yaw()) || (!whole_shift && !estimate_.has_position()))
    return refuse(PlaneRefusal::unobserved);
  result_.verdict = whole_turn && whole_shift ? PlaneVerdict::placed : PlaneVerdict::placed_partly;
}

const char* to_string(PlaneVerdict verdict) {
  constexpr const char* kNames[] = {"none", "working", "placed", "placed partly", "refused", "ambiguous"};
  return kNames[static_cast<int>(verdict)];
}

const char* to_string(PlaneRefusal refusal) {
  constexpr const char* kNames[] = {"none",         "no planes",       "few matches",
                                    "little share", "little evidence", "unobserved",
                                    "runner-up",    "mirrored"};
  return kNames[static_cast<int>(refusal)];
}

}  // namespace sortie::mapping
