// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_registration.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
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
  credit_.clear();
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
    if (!credit_.pay(cost, units)) return false;
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
  candidates_.find_shifts(scales_[scale_], estimate_);
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

/// Where one target plane is the only one within 60 degrees of its direction: how unlike its area and that of
/// its partners together are, as a ratio of 1 or more. The largest of them; 0 where all directions are held
/// by two. A box's top on the floor, with no second plane that says at which height, is the case to fear.
double PlaneRegistration::alone_ratio(const Fitted& best) const {
  const double grown = best.fit.T_target_source.scale * best.fit.T_target_source.scale;
  double most = 0.0;
  for (const PlanePair& pair : best.pairs) {
    bool alone = true;
    double source_m2 = 0.0;
    for (const PlanePair& other : best.pairs) {
      if (other.target == pair.target)
        source_m2 += grown * source_[other.source].area_m2;
      else
        alone = alone && std::fabs(rt::dot(target_[pair.target].normal, target_[other.target].normal)) < 0.5;
    }
    if (!alone) continue;
    const double here = std::max(target_[pair.target].area_m2, 1e-6);
    const double there = std::max(source_m2, 1e-6);
    most = std::max({most, here / there, there / here});
  }
  return most;
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
  const bool known = estimate_.has_position() && estimate_.has_yaw();
  if (result_.mirror_rivalry > (known ? config_.most_mirrored_known : config_.most_mirrored))
    return refuse(PlaneRefusal::mirrored);
  if ((!whole_turn && !estimate_.has_yaw()) || (!whole_shift && !estimate_.has_position()))
    return refuse(PlaneRefusal::unobserved);
  if (alone_ratio(best) > config_.most_area_ratio_alone) return refuse(PlaneRefusal::unobserved);
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
