// SPDX-License-Identifier: BSD-3-Clause
// A scan that is held against the places that segments say, as part `recognise` does.
#pragma once

#include <functional>
#include <span>

#include "mapping/registration/place_judge.hpp"
#include "tests/bench/recognition/local_run.hpp"

namespace sortie::bench {

/// Surfaces that scans have left, and a judge of places on them: windows of 128 m.
struct SurfaceMap {
  TrialMemory memory;
  mapping::ScanRegistration registration;
  mapping::PlaceJudge judge;
  explicit SurfaceMap(const mapping::RelocateConfig& config);
};

/// A scan's sample, where the odometry has it, and its attitude as it is known.
struct CheckedScan {
  std::span<const mapping::SamplePoint> sample;
  mapping::RigidPose T_odom_sensor;
  rt::Quaternion q_level_sensor;
};

/// T_known_odom of the places that are found, the best one first; none where nothing is found.
using FoundPlaces = std::function<std::vector<mapping::RigidPose>()>;

/// While a place is found: holds the scan against it and the others that are spoken for. One that the scan
/// refuses is left out by `refuse`, and the search goes on. `surfaces` gives the judge of what is found then.
/// True: the scan fits where the first place is, and `judged` has where.
bool place_by_scan(const CheckedScan& scan, const FoundPlaces& found, const std::function<void()>& refuse,
                   const std::function<mapping::PlaceJudge&()>& surfaces, mapping::JudgedPlace& judged);

/// The same of what segments say.
bool place_by_scan(const CheckedScan& scan, mapping::Recogniser& recogniser,
                   const mapping::TargetStore& store, const std::function<mapping::PlaceJudge&()>& surfaces,
                   mapping::JudgedPlace& judged);

}  // namespace sortie::bench
