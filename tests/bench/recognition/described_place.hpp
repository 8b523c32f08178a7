// SPDX-License-Identifier: BSD-3-Clause
// A place by the segments that speak there, and by two published descriptors of places.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mapping/recognition/target_store.hpp"
#include "tests/bench/recognition/density_features.hpp"
#include "tests/bench/recognition/hall_places.hpp"
#include "tests/bench/recognition/local_run.hpp"
#include "tests/bench/recognition/solid_vector.hpp"

namespace sortie::bench {

/// SOLiD of a scan and of a local map, with published settings and with those of a hall.
struct SolidVariant {
  const char* name;
  bool of_scan;
  SolidConfig config;
};
inline constexpr SolidVariant kSolids[] = {{"SOLiD, scan, as published", true, {}},
                                           {"SOLiD, scan, 25 m", true, {0.0, 25.0, 0.0}},
                                           {"SOLiD, local map, 80 m", false, {0.0, 80.0, 0.0}},
                                           {"SOLiD, local map, 25 m", false, {0.0, 25.0, 0.0}}};

/// Density images by their pixels, m; the first is the published one.
inline constexpr double kPixels_m[] = {0.5, 0.2, 0.1};

/// The segments of one place, kept as targets.
class PlaceTargets {
 public:
  explicit PlaceTargets(const std::vector<mapping::SpeakingSegment>& segments);
  const mapping::TargetStore& store() const { return store_; }

 private:
  static mapping::TargetStoreConfig store_config();
  TrialMemory memory_;
  mapping::TargetStore store_;
};

/// What is known of a place; what it was made from is given up.
struct DescribedPlace {
  std::size_t hall{};
  SecondWay way{};
  rt::Vector3 at;
  std::vector<SolidVector> solid;                     ///< in the order of kSolids
  std::vector<std::vector<DensityFeature>> features;  ///< in the order of kPixels_m
  std::vector<mapping::SpeakingSegment> segments;
  std::unique_ptr<PlaceTargets> targets;

  explicit DescribedPlace(const HallPlace& place);
};

/// Says how many segments of two places agree: as the recogniser finds it, of three segments or more.
class AgreeingSegments {
 public:
  AgreeingSegments();
  /// Of the best pose's set; 0: there is none.
  std::uint32_t count(const DescribedPlace& known, const DescribedPlace& asked);

 private:
  TrialMemory memory_;
  mapping::Recogniser recogniser_;
};

}  // namespace sortie::bench
