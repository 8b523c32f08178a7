// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/cloud_registration.hpp"

#include <algorithm>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kOfWall = 0.9;           ///< least part of a squared normal that is level
constexpr std::uint64_t kUnitsLook = 30;  ///< a cell, in both its looks
constexpr std::uint64_t kUnitsFit = 8;    ///< a cell and a step
constexpr double kQuarter = 1.5707963267948966;
}  // namespace

CloudRegistration::CloudRegistration(const CloudRegistrationConfig& config)
    : config_(config), plane_registration_(config.planes) {}

void CloudRegistration::take_cells(const SightLayer& from, SightCell (&cells)[kMostCells],
                                   std::uint32_t& count) {
  const std::span<const SightCell> all = from.cells();
  count = static_cast<std::uint32_t>(std::min<std::size_t>(all.size(), kMostCells));
  for (std::size_t i = 0; i < count; ++i) cells[i] = all[i * all.size() / count];
}

/// The upright, and the two directions square to it that walls face: a wall counts the same whichever of its
/// four sides it shows, so that angles are summed up four times as large.
void CloudRegistration::find_axes() {
  double sine = 0.0;
  double cosine = 0.0;
  for (const SightCell& cell : target_cells()) {
    const double x = cell.normal.x, y = cell.normal.y;
    const double level2 = x * x + y * y;
    if (level2 < kOfWall) continue;
    const double c = (x * x - y * y) / level2, s = 2.0 * x * y / level2;  // of twice the angle
    cosine += c * c - s * s;
    sine += 2.0 * c * s;
  }
  const double angle = sine == 0.0 && cosine == 0.0 ? 0.0 : 0.25 * rt::atan2(sine, cosine);
  axis_[0] = {rt::cos(angle), rt::sin(angle), 0.0};
  axis_[1] = {-axis_[0].y, axis_[0].x, 0.0};
  axis_[2] = {0.0, 0.0, 1.0};
}

Status CloudRegistration::begin(const PlaneSet& source_planes, const SightLayer& source,
                                const PlaneSet& target_planes, const SightLayer& target,
                                const PlaneEstimate& estimate) {
  result_ = {};
  planes_result_ = {};
  stage_ = Stage::done;
  credit_.clear();
  place_count_ = best_ = pass_ = 0;
  const Status status = plane_registration_.begin(source_planes, target_planes, estimate);
  if (status != Status::ok) return status;
  source_ = &source;
  target_ = &target;
  estimate_ = estimate;
  take_cells(source, source_cells_, source_count_);
  take_cells(target, target_cells_, target_count_);
  result_.cells = source_count_ + target_count_;
  find_axes();
  middle_m_ = {};
  for (const SightCell& cell : source_cells()) middle_m_ = middle_m_ + (1.0 / source_count_) * cell.mean_m;
  result_.verdict = CloudVerdict::working;
  stage_ = Stage::planes;
  return Status::ok;
}

std::uint64_t CloudRegistration::next_cost() const {
  switch (stage_) {
    case Stage::vote:
      return 2 * SightVotes::kUnits;
    case Stage::fit:
      return kUnitsFit * kFitSteps * source_count_ + 1;
    default:
      return kUnitsLook * result_.cells + 1;
  }
}

bool CloudRegistration::run(std::uint64_t& units) {
  while (stage_ != Stage::done) {
    if (stage_ == Stage::planes) {
      const std::uint64_t before = units;
      const bool ended = plane_registration_.run(units);
      result_.units += before - units;
      if (!ended) return false;
      end_planes();
      continue;
    }
    const std::uint64_t cost = next_cost();
    if (!credit_.pay(cost, units)) return false;
    result_.units += cost;
    step();
  }
  return true;
}

void CloudRegistration::step() {
  switch (stage_) {
    case Stage::vote:
      vote();
      break;
    case Stage::fit:
      fit();
      break;
    case Stage::look:
      settle();
      break;
    default:
      hold();
  }
}

/// What the planes lead to waits to be settled.
void CloudRegistration::end_planes() {
  planes_result_ = plane_registration_.result();
  starts_.clear();
  for (std::uint32_t k = 0; k < plane_registration_.places() && k < config_.starts; ++k)
    (void)starts_.push_back(plane_registration_.place(k));
  start_ = round_ = shift_ = 0;
  stage_ = Stage::fit;
  if (starts_.empty()) end_pass();
}

/// False: that was the last one.
bool CloudRegistration::next_pass() {
  while (++pass_ < kPasses) {
    // A quarter or a half turn from a yaw that is known is nowhere near.
    const bool turned = (pass_ - 1) % 4 != 0;
    if (turned && estimate_.has_yaw()) continue;
    stage_ = Stage::vote;
    return true;
  }
  return false;
}

/// The best place, turned about the middle of the source or mirrored there, at each combination of shifts.
void CloudRegistration::vote() {
  const PlanePose& best = places_[best_].pose;
  PlanePose turned = best;
  turned.q_target_source =
      rt::normalised(rt::from_yaw_pitch_roll(kQuarter * ((pass_ - 1) % 4), 0, 0) * best.q_target_source);
  rt::Vector3 middle = middle_m_;
  if (in_mirror()) {
    mirror_ = rt::rotate_back(best.q_target_source, axis_[0]);
    middle = mirrored(middle, mirror_);
    for (std::uint32_t i = 0; i < source_count_; ++i) image_cells_[i] = mirrored(source_cells_[i], mirror_);
  }
  turned.p_target_source_m = {};
  turned.p_target_source_m = transform(best, middle_m_) - transform(turned, middle);
  const double ratio = best.scale * source_->cell_m() / target_->cell_m();
  rt::FixedVector<double, kMostSightPeaks> shifts[2];
  for (int k = 0; k < 2; ++k)
    votes_.find(source_cells(), turned, target_cells(), axis_[k], ratio * ratio, shifts[k]);
  starts_.clear();
  for (const double first : shifts[0]) {
    for (const double second : shifts[1]) {
      PlanePose start = turned;
      start.p_target_source_m = start.p_target_source_m + first * axis_[0] + second * axis_[1];
      (void)starts_.push_back(start);
    }
  }
  start_ = round_ = shift_ = 0;
  stage_ = Stage::fit;
  if (starts_.empty()) end_pass();
}

const char* to_string(CloudVerdict verdict) {
  constexpr const char* kNames[] = {"none", "working", "placed", "refused", "ambiguous"};
  return kNames[static_cast<int>(verdict)];
}

const char* to_string(CloudRefusal refusal) {
  constexpr const char* kNames[] = {"none",   "no place", "little", "crossed",  "scale",
                                    "unheld", "rival",    "turn",   "mirrored", "alone"};
  return kNames[static_cast<int>(refusal)];
}

}  // namespace sortie::mapping
