// SPDX-License-Identifier: BSD-3-Clause
// The height images of a trial: what was kept, and what the robot's own one says, as on board.
#pragma once

#include <functional>

#include "mapping/recognition/height_imager.hpp"
#include "mapping/recognition/image_search.hpp"
#include "tests/bench/recognition/recognition_trials.hpp"
#include "tests/bench/recognition/scan_check.hpp"

namespace sortie::bench {

/// Keeps images of local maps and looks for one among them.
class ImageTrial {
 public:
  ImageTrial(const mapping::ImageSearchConfig& search, double second_look_m);

  /// The map's image where it is now, in the frame that is kept.
  void keep(const mapping::RollingGrid& grid);
  std::uint32_t kept() const { return static_cast<std::uint32_t>(images_.images().size()); }
  /// Searches, and holds the scan that `scan` gives against what is found.
  void look(const mapping::RollingGrid& grid, const mapping::RigidPose& odom, const mapping::RigidPose& truth,
            const std::function<CheckedScan()>& scan, mapping::PlaceJudge& judge, ImageLook& look);

 private:
  bool draw(const mapping::RollingGrid& grid);

  TrialMemory memory_;
  mapping::ImageStore images_;
  mapping::HeightImager imager_;
  mapping::ImageSearch search_;
  mapping::PlaceLooks looks_;
};

}  // namespace sortie::bench
