// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/image_trial.hpp"

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/recognition/owned_sets.hpp"

namespace sortie::bench {
using namespace mapping;

ImageTrial::ImageTrial(const ImageSearchConfig& search, double second_look_m)
    : memory_(2), images_({}, memory_.arena), search_(search), looks_({second_look_m, second_look_m}) {
  memory_.check();
}

bool ImageTrial::draw(const RollingGrid& grid) {
  imager_.begin(grid);
  while (imager_.is_working()) (void)imager_.run(grid, ~std::uint32_t{0});
  return imager_.stage() == ImageStage::drawn;
}

void ImageTrial::keep(const RollingGrid& grid) {
  if (draw(grid)) (void)images_.put(imager_.image(), {imager_.image().middle, {}}, 0, 0);
}

void ImageTrial::look(const RollingGrid& grid, const RigidPose& odom, const RigidPose& truth,
                      const std::function<CheckedScan()>& scan, PlaceJudge& judge, ImageLook& look) {
  look.verdict = ImageVerdict::few;
  if (!draw(grid)) return;
  constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;
  const double begin = set_cpu_ms();
  search_.begin(imager_.image());
  std::uint64_t units = kAll;
  (void)search_.run(images_, units);
  look.ms = set_cpu_ms() - begin;
  look.units = kAll - units;
  look.verdict = search_.verdict();
  if (search_.found().empty()) return;
  const auto first = search_.found();
  look.best = error_of(after(pose_of(first[0].place), odom), truth);
  look.agree = first[0].score.agree;
  if (first.size() > 1) look.rival = static_cast<double>(first[1].score.total()) / first[0].score.total();
  if (look.verdict != ImageVerdict::found) return;
  const auto found = [this] {
    std::vector<RigidPose> places;
    if (search_.verdict() != ImageVerdict::found) return places;
    for (const ImageHypothesis& one : search_.found()) places.push_back(pose_of(one.place));
    return places;
  };
  const CheckedScan checked = scan();
  const bool placed = place_by_scan(
      checked, found, [this] { search_.refuse(images_); }, [&judge]() -> PlaceJudge& { return judge; },
      look.judged);
  look.scan = look.judged.verdict;
  if (!placed) return;
  look.placed = error_of(look.judged.T_map_sensor, truth);
  look.judged.sure = false;
  look.confirmed = looks_.take(look.judged, odom);
}

}  // namespace sortie::bench
