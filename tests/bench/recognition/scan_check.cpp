// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/scan_check.hpp"

#include "mapping/registration/pose_algebra.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;

constexpr double kSameMove = 1.0;  ///< m and rad: a scan fits where the segments say
constexpr double kSameTurn = 0.2;
constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;
constexpr RegistrationMemory kSurfaces{65'536, 256, 64};

}  // namespace

SurfaceMap::SurfaceMap(const RelocateConfig& config)
    : memory(80), registration({}, memory.arena, kSurfaces), judge(config, registration, memory.arena) {
  memory.check();
}

bool place_by_scan(const CheckedScan& scan, const FoundPlaces& found, const std::function<void()>& refuse,
                   const std::function<PlaceJudge&()>& surfaces, JudgedPlace& judged) {
  for (std::vector<RigidPose> places = found(); !places.empty(); places = found()) {
    PlaceJudge& judge = surfaces();
    if (!judge.begin(scan.sample, scan.q_level_sensor)) return false;
    for (const RigidPose& place : places) judge.add(after(place, scan.T_odom_sensor));
    std::uint64_t units = kAll;
    (void)judge.run(units, judged);
    const RigidPose told = after(places[0], scan.T_odom_sensor);
    if (judged.verdict == RelocateVerdict::placed &&
        !are_apart(judged.T_map_sensor, told, kSameMove, kSameTurn))
      return true;
    refuse();
  }
  return false;
}

bool place_by_scan(const CheckedScan& scan, Recogniser& recogniser, const TargetStore& store,
                   const std::function<PlaceJudge&()>& surfaces, JudgedPlace& judged) {
  const auto found = [&recogniser] {
    std::vector<RigidPose> places;
    if (recogniser.verdict() != SetVerdict::found) return places;
    for (const SetHypothesis& place : recogniser.found()) places.push_back(pose_of(place.fit.place));
    return places;
  };
  const auto refuse = [&] {
    recogniser.refuse();
    std::uint64_t units = kAll;
    (void)recogniser.run(store, units);
  };
  return place_by_scan(scan, found, refuse, surfaces, judged);
}

}  // namespace sortie::bench
