// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_hypothesis.hpp"

namespace sortie::mapping {
namespace {

constexpr std::int64_t kSameCm = 100;
constexpr double kSameCosine = 0.985;  ///< 10 degrees

double number(std::int32_t parts) { return static_cast<double>(parts) / Heading::kOne; }

}  // namespace

ImageHypothesis hypothesis_of(const ImageStore& store, const ImageTurns& turns, const PlaceCm& middle,
                              std::uint32_t image, const ImagePlace& place) {
  ImageHypothesis out;
  const KeyFramePose& pose = store.images()[image].pose;
  out.image = image;
  out.on_image = place;
  out.middle = place_of(pose, {HeightImage::kCellCm * place.x, HeightImage::kCellCm * place.y, 0});
  out.heading = after(turns.heading(place.turn), pose.heading);
  const double c = number(out.heading.cosine), s = number(out.heading.sine);
  out.place = {c, s, 0.01 * (out.middle.x - (c * middle.x - s * middle.y)),
               0.01 * (out.middle.y - (s * middle.x + c * middle.y)), 0.01 * (out.middle.z - middle.z)};
  return out;
}

bool is_same(const ImageHypothesis& a, const ImageHypothesis& b) {
  const double cosine =
      number(a.heading.cosine) * number(b.heading.cosine) + number(a.heading.sine) * number(b.heading.sine);
  return square_apart(a.middle, b.middle) <= kSameCm * kSameCm && cosine >= kSameCosine;
}

}  // namespace sortie::mapping
