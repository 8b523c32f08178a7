// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/described_place.hpp"

#include <stdexcept>

namespace sortie::bench {

using namespace mapping;

TargetStoreConfig PlaceTargets::store_config() {
  TargetStoreConfig config;
  config.targets = RecogniserConfig{}.segments;
  config.key_frames = 1;
  return config;
}

PlaceTargets::PlaceTargets(const std::vector<SpeakingSegment>& segments)
    : memory_(1), store_(store_config(), memory_.arena) {
  memory_.check();
  const KeyFramePose frame;
  if (store_.set_key_frame(0, frame) != Status::ok) throw std::runtime_error("places: no key frame");
  for (const SpeakingSegment& segment : segments) {
    TargetSighting sighting;
    sighting.id = segment.id;
    sighting.version = static_cast<std::uint16_t>(segment.version);
    sighting.offset = offset_of(frame, segment.place);
    sighting.descriptor = segment.descriptor;
    if (store_.put(sighting).status != Status::ok) throw std::runtime_error("places: a segment too far");
  }
  std::uint64_t all = ~std::uint64_t{0} >> 1;
  (void)store_.run(all);
}

DescribedPlace::DescribedPlace(const HallPlace& place)
    : hall(place.hall), way(place.way), at(place.at), segments(place.segments) {
  for (const SolidVariant& variant : kSolids)
    solid.push_back(solid_vector(variant.of_scan ? place.scan : place.voxels, variant.config));
  for (const double pixel_m : kPixels_m) features.push_back(density_features(place.voxels, pixel_m));
  if (place.visit == 0) targets = std::make_unique<PlaceTargets>(place.segments);
}

namespace {
RecogniserConfig of_three() {
  RecogniserConfig config;
  config.set.least = 3;
  return config;
}
}  // namespace

AgreeingSegments::AgreeingSegments() : memory_(4), recogniser_(of_three(), memory_.arena) { memory_.check(); }

std::uint32_t AgreeingSegments::count(const DescribedPlace& known, const DescribedPlace& asked) {
  recogniser_.begin(asked.segments, {});
  std::uint64_t all = ~std::uint64_t{0} >> 1;
  (void)recogniser_.run(known.targets->store(), all);
  return recogniser_.found().empty() ? 0 : recogniser_.found()[0].count;
}

}  // namespace sortie::bench
