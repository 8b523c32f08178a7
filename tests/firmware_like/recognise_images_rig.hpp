// SPDX-License-Identifier: BSD-3-Clause
// The hall of recognise_rig.hpp as height images, and runs of a robot that is lost there and goes by them.
#pragma once

#include <string>
#include <vector>

#include "mapping/recognition/image_file.hpp"
#include "tests/firmware_like/recognise_rig.hpp"

namespace sortie::testing {

inline std::vector<std::uint8_t> image_bytes(const mapping::ImageStore& images) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::image_file_bytes(images)));
  REQUIRE(mapping::write_images(images, bytes) == Status::ok);
  return bytes;
}

/// Images by themselves: the part that recognises segments is left out, and so are segments.
inline const std::vector<std::string> kImagesAlone = {"tasks.recognise_images.enabled=true",
                                                      "tasks.recognise.enabled=false", "map.segments=off"};

/// What that drive's images are, made from its log; once.
struct SeenImages {
  TempFolder folder;
  firmware::KeptMapPaths kept{seen_hall().kept.map, "", folder.file("hall.images")};
  firmware::ReplayOutcome outcome = [] {
    firmware::ReplayOptions options;
    options.overrides = kImagesAlone;
    return replay_log(seen_hall().log, options);
  }();
  std::vector<std::uint8_t> bytes;
  SeenImages() {
    const mapping::ImageStore* images = outcome.runtime->vehicle().images();
    REQUIRE(images != nullptr);
    bytes = image_bytes(*images);
    write(kept.images, bytes);
  }
};
inline const SeenImages& seen_images() {
  static const SeenImages seen;
  return seen;
}

/// A robot that is lost there and begins at the other end, turned to the left: no pose of this way is that of
/// the other one, nor its inverse.
inline firmware::LiveRunOutcome run_turned(double seconds, const std::string& log,
                                           const firmware::KeptMapPaths& kept,
                                           const std::vector<std::string>& more) {
  std::vector<std::string> overrides = kImagesAlone;
  overrides.insert(overrides.end(), more.begin(), more.end());
  overrides.insert(
      overrides.end(),
      {"locate.window_cells=256", "hil.start_x_m=14", "hil.start_yaw_deg=90",
       "mission.waypoints=[[4.0,0.0],[4.0,4.7],[0.0,4.7],[0.0,14.0],[-4.0,14.0],[-4.0,4.7],[-4.0,"
       "0.0],[0.0,0.0]]"});
  return run_recognising(seconds, log, kept, overrides);
}

/// A robot that is lost there, and takes the hall the other way round.
inline firmware::LiveRunOutcome run_lost_by_images(double seconds, const std::string& log,
                                                   const firmware::KeptMapPaths& kept,
                                                   const std::vector<std::string>& more) {
  std::vector<std::string> overrides = kImagesAlone;
  overrides.insert(overrides.end(), more.begin(), more.end());
  return run_lost(seconds, log, overrides, kept);
}

}  // namespace sortie::testing
