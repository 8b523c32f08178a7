// SPDX-License-Identifier: BSD-3-Clause
// Other places of the registration of clouds: the best one turned and mirrored, at the shifts that cells vote
// for.
#include <algorithm>

#include "mapping/registration/cloud_registration.hpp"

namespace sortie::mapping {
namespace {
constexpr double kQuarter = 1.5707963267948966;
}  // namespace

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

}  // namespace sortie::mapping
