// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/place_judge.hpp"

namespace sortie::mapping {

void PlaceJudge::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "place_judge")
      .fixed(config_, registration_)
      .scratch(cubes_, weights_, weight_)
      .by_hand(sample_, bits_)
      .state(size_, q_level_sensor_, step_, at_, count_, places_, credit_, units_);
  if (archive.is_reading()) {
    bool fits = step_ <= Step::verdict && size_ <= sample_.size() &&
                count_ <= PlaceSearchConfig::kMostCandidates && at_ <= count_;
    for (const Place& place : places_) fits = fits && place.slot < PlaceSearchConfig::kMostCandidates;
    if (!fits) {
      archive.fail(Status::malformed, "places to judge that cannot be");
      size_ = at_ = count_ = 0;
      step_ = Step::idle;
    }
    check_pose(archive, {{}, q_level_sensor_});
    for (const Place& place : places_) check_pose(archive, place.pose);
  }
  if (step_ == Step::idle) return;
  for (SamplePoint& point : sample_.first(size_)) {
    archive.value(point.x_m);
    archive.value(point.y_m);
    archive.value(point.z_m);
  }
  // What a place explains was counted on the map as it was then: with what a robot that is placed has added
  // to it since, it would be more.
  for (const Place& place : std::span<const Place>{places_}.first(step_ == Step::tries ? at_ : count_)) {
    for (std::size_t i = 0; i < 3 * words(); ++i) archive.value(explained_bits(place)[i]);
  }
  if (archive.is_reading()) weigh_returns();
}

}  // namespace sortie::mapping
