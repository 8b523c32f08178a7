// SPDX-License-Identifier: BSD-3-Clause
// The height of the best place.
#include <algorithm>
#include <cmath>

#include "mapping/registration/relocaliser.hpp"

namespace sortie::mapping {
namespace {
constexpr double kHeight_m = 0.1;  ///< between the heights that are tried
constexpr std::uint32_t kCoarseHeights = 11;
constexpr double kSameHeight = 0.006;  ///< of the returns: one height does as well as another
constexpr double kSameAsFree = 0.001;
}  // namespace

/// Of the heights that are tried: where the place is, ever farther off on both sides, then beside the best.
double Relocaliser::rise_m(std::uint32_t height) const {
  const double side = height % 2 == 0 ? -1.0 : 1.0;
  if (height < kCoarseHeights) return side * kHeight_m * ((height + 1) / 2);
  const auto best =
      static_cast<std::uint32_t>(std::max_element(heights_, heights_ + kCoarseHeights) - heights_);
  return rise_m(best) + side * 0.5 * kHeight_m;
}

/// A floor between storeys that the map has seen from above and from below is one thick surface to it, which
/// draws a match into its middle. So the thin surfaces alone are matched to, and where another height
/// explains more than what they found, they are too few.
bool Relocaliser::run_heights(std::uint64_t& units) {
  if (count_ == 0) return true;
  for (; at_ <= kHeights; ++at_) {
    if (!pay_looks(size_, units)) return false;
    Place place = places_[0];
    place.slot = kSpare;
    registration_->take_sample(sample());
    if (at_ == 0) {
      level_ = place.pose;
      keep(registration_->match_from(level_, prior_at(level_, kFreeTilt), size_, true), place);
      free_ = place.pose;
      explained_free_ = place.explained;
      continue;
    }
    const std::uint32_t height = at_ - 1;
    place.pose = {level_.p + rt::Vector3{0, 0, rise_m(height)}, level_.q};
    keep(registration_->match_from(place.pose, prior_at_height(place.pose), size_, true), place);
    heights_[height] = place.explained;
    if (height == 0 || heights_[height] > *std::max_element(heights_, heights_ + height))
      places_[0].pose = place.pose;
  }
  return true;
}

/// The best height explains no more, to speak of, than what the match found.
bool Relocaliser::is_free() const {
  return explained_free_ + kSameAsFree * size_ >= *std::max_element(heights_, heights_ + kHeights);
}

/// No height well apart from the best one does about as well.
bool Relocaliser::is_height_held() const {
  const auto best = static_cast<std::uint32_t>(std::max_element(heights_, heights_ + kHeights) - heights_);
  for (std::uint32_t i = 0; i < kHeights; ++i) {
    const double apart_m = std::fabs(rise_m(i) - rise_m(best));
    if (apart_m > 0.9 * kHeight_m && heights_[i] > heights_[best] - kSameHeight * size_) return false;
  }
  return true;
}

}  // namespace sortie::mapping
