// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/relocaliser.hpp"

#include "mapping/registration/place_returns.hpp"

namespace sortie::mapping {

Relocaliser::Relocaliser(const RelocateConfig& config, const PlaceSearchConfig& search,
                         const RegistrationMemory& memory, ScanRegistration& registration, rt::Arena& arena)
    : registration_(&registration),
      map_(memory, search.tops, arena),
      search_(search, map_, arena),
      judge_(config, registration, arena) {}

void Relocaliser::begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor) {
  const RelocateCounts counts = result_.counts;
  result_ = {};
  result_.verdict = RelocateVerdict::searching;
  result_.counts = counts;
  ++result_.counts.begun;
  const bool enough = judge_.begin(sample, q_level_sensor);
  rt::Vector3 returns_m[PlaceSearchConfig::kMostReturns];
  const std::span<rt::Vector3> wanted{returns_m, search_.config().returns};
  const std::size_t few =
      choose_place_returns(judge_.sample(), judge_.q_level_sensor(), search_.config().reach_m, wanted);
  result_.searched = static_cast<std::uint32_t>(few);
  if (!enough || few < PlaceSearchConfig::kLeastReturns) return conclude(RelocateVerdict::few_returns);
  search_.begin(wanted.first(few));
  searched_ = false;
}

bool Relocaliser::run(std::uint64_t& units) {
  if (!is_searching()) return true;
  if (!searched_) {
    if (!search_.run(units)) return false;
    searched_ = true;
    const std::span<const PlaceCandidate> found = search_.found();
    result_.candidates = static_cast<std::uint32_t>(found.size());
    if (!found.empty()) result_.hits = found[0].hits;
    for (const PlaceCandidate& candidate : found) {
      const rt::Quaternion turn = rt::exp_rotation({0, 0, PlaceSearch::turn_rad(candidate.cell.turn)});
      judge_.add({map_.position_m(candidate.cell), rt::normalised(turn * judge_.q_level_sensor())});
    }
  }
  const bool done = judge_.run(units, result_);
  result_.units = search_.counts().units + judge_.units();
  if (done) conclude(result_.verdict);
  return done;
}

void Relocaliser::conclude(RelocateVerdict verdict) {
  RelocateCounts& counts = result_.counts;
  if (verdict == RelocateVerdict::placed) ++counts.placed;
  if (verdict == RelocateVerdict::ambiguous) ++counts.ambiguous;
  if (verdict == RelocateVerdict::nothing_fits) ++counts.nothing_fits;
  if (verdict == RelocateVerdict::few_returns) ++counts.few_returns;
  result_.verdict = verdict;
}

void Relocaliser::archive(rt::Archive& archive) {
  // The map's bits follow from its surfaces. Nobody asks for them where nothing is searched, and a map that
  // has grown is no kept map.
  rt::Members(archive, *this, "relocaliser")
      .fixed(registration_, map_)
      .by_hand(search_, judge_)
      .state(searched_, result_);
  if (archive.is_reading() && result_.verdict > RelocateVerdict::few_returns)
    archive.fail(Status::malformed, "a search of a place that cannot be");
  if (!is_searching()) return;
  if (archive.is_reading() && !take_map()) archive.fail(Status::malformed, "a search without a map");
  archive.value(search_);
  archive.value(judge_);
}

}  // namespace sortie::mapping
