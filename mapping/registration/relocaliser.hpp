// SPDX-License-Identifier: BSD-3-Clause
// Where on a kept map a robot is that knows nothing of it, from one scan; or that the scan does not say.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/place_search.hpp"

namespace sortie::mapping {

/// Searches by verdict. begun = all others and the one that goes on.
struct RelocateCounts {
  std::uint64_t begun{};
  std::uint64_t placed{};
  std::uint64_t ambiguous{};
  std::uint64_t nothing_fits{};
  std::uint64_t few_returns{};
  SORTIE_FIELDS(begun, placed, ambiguous, nothing_fits, few_returns)
};

/// What a search found.
struct Relocated : JudgedPlace {
  std::uint32_t hits{};  ///< in the search, of `searched` returns
  std::uint32_t searched{};
  std::uint32_t candidates{};
  std::uint64_t units{};  ///< of work
  RelocateCounts counts;
  SORTIE_FIELDS(verdict, T_map_sensor, covariance, share, seen, crossed, lead, denied, rival, unexplained,
                sure, hits, searched, candidates, units, counts)
};

/// Searches, and has what it found judged. All memory is taken from the arena; no heap. The same bits
/// whatever the budgets and the order of a scan's returns; arithmetic of rt/math alone. A unit is one look at
/// a return for 64 poses. Memory beside the map's bits and the search: PlaceJudge's.
class Relocaliser {
 public:
  /// `registration` has the map, and outlives it.
  Relocaliser(const RelocateConfig& config, const PlaceSearchConfig& search, const RegistrationMemory& memory,
              ScanRegistration& registration, rt::Arena& arena);

  /// Takes the registration's map as it is. Set-up only. False: there is none, or it has more blocks than
  /// PlaceSearchConfig::tops.
  [[nodiscard]] bool take_map() { return map_.build(registration_->layer(0)); }
  bool has_map() const { return !map_.empty(); }

  /// Begins with a sample. `q_level_sensor`: the scan's attitude; its turn about the upright means nothing.
  void begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor);
  bool is_searching() const { return result_.verdict == RelocateVerdict::searching; }
  /// Works on for at most `units`, and takes what it used off. True: there is an answer. It uses the
  /// registration's sample.
  bool run(std::uint64_t& units);
  const Relocated& result() const { return result_; }
  const PlaceSearch& search() const { return search_; }
  const PlaceMap& map() const { return map_; }
  /// The map is the same: it is built anew from the registration's, which is archived before.
  void archive(rt::Archive& archive);

 private:
  void conclude(RelocateVerdict verdict);

  ScanRegistration* registration_;
  PlaceMap map_;
  PlaceSearch search_;
  PlaceJudge judge_;
  bool searched_{};  ///< what was found is being judged
  Relocated result_;
};

}  // namespace sortie::mapping
