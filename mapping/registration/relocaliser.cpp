// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/relocaliser.hpp"

#include <algorithm>

#include "mapping/registration/place_returns.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::mapping {
namespace {
constexpr std::size_t kLeastSample = 100;  ///< of a sample
constexpr double kPlaceMove = 0.5;         ///< m and rad: two places are two
constexpr double kPlaceTurn = 0.17;
}  // namespace

PosePrior Relocaliser::prior_at(const RigidPose& pose) {
  PosePrior prior;
  prior.at = pose;
  for (int i = 0; i < 6; ++i) prior.information[i][i] = 0.01;
  return prior;
}

const char* to_string(RelocateVerdict verdict) {
  constexpr const char* kNames[] = {"none",      "searching",    "placed",
                                    "ambiguous", "nothing fits", "few returns"};
  const auto at = static_cast<std::size_t>(verdict);
  return at < std::size(kNames) ? kNames[at] : "unknown";
}

Relocaliser::Relocaliser(const RelocateConfig& config, const PlaceSearchConfig& search,
                         const RegistrationMemory& memory, ScanRegistration& registration, rt::Arena& arena)
    : config_(config),
      registration_(&registration),
      map_(memory, search.tops, arena),
      search_(search, map_, arena),
      sample_(arena.make_array<SamplePoint>("relocate_sample", registration.config().returns)),
      bits_(arena.make_array<std::uint64_t>(
          "relocate_bits", 2 * PlaceSearchConfig::kMostCandidates * ((sample_.size() + 63) / 64))) {}

void Relocaliser::begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor) {
  size_ = static_cast<std::uint32_t>(std::min(sample.size(), sample_.size()));
  std::copy_n(sample.begin(), size_, sample_.begin());
  q_level_sensor_ = rt::normalised(q_level_sensor);
  at_ = count_ = 0;
  credit_.clear();
  result_ = {RelocateVerdict::searching, {}, {}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, result_.counts};
  ++result_.counts.begun;
  rt::Vector3 returns_m[PlaceSearchConfig::kMostReturns];
  const std::span<rt::Vector3> wanted{returns_m, search_.config().returns};
  const std::size_t few =
      choose_place_returns(this->sample(), q_level_sensor_, search_.config().reach_m, wanted);
  result_.searched = static_cast<std::uint32_t>(few);
  if (size_ < kLeastSample || few < PlaceSearchConfig::kLeastReturns)
    return conclude(RelocateVerdict::few_returns);
  search_.begin(wanted.first(few));
  step_ = Step::search;
}

bool Relocaliser::pay(std::uint64_t cost, std::uint64_t& units) {
  if (!credit_.pay(cost, units)) return false;
  result_.units += cost;
  return true;
}

bool Relocaliser::run(std::uint64_t& units) {
  if (step_ == Step::search) {
    if (!search_.run(units)) return false;
    result_.units += search_.counts().units;
    const std::span<const PlaceCandidate> found = search_.found();
    count_ = result_.candidates = static_cast<std::uint32_t>(found.size());
    if (count_ > 0) result_.hits = found[0].hits;
    step_ = Step::tries;
  }
  if (step_ == Step::tries) {
    if (!run_tries(units)) return false;
    order();
    count_ = std::min(count_, kTried);
    at_ = 0;
    step_ = Step::retries;
  }
  if (step_ == Step::retries) {
    if (!run_retries(units)) return false;
    order();
    at_ = 0;
    step_ = Step::verdict;
  }
  if (step_ == Step::verdict) {
    if (!pay_match(4 * std::size_t{size_}, units)) return false;
    conclude(judge());
  }
  return true;
}

/// Its steps, and looking at what it explains.
bool Relocaliser::pay_match(std::size_t returns, std::uint64_t& units) {
  return pay((registration_->config().steps + 8) * std::uint64_t{kMatchUnits} * returns, units);
}

/// Each candidate from where the search found it, with some of the returns.
bool Relocaliser::run_tries(std::uint64_t& units) {
  const std::size_t returns = std::min<std::size_t>(size_, config_.first_returns);
  for (; at_ < count_; ++at_) {
    if (!pay_match(returns, units)) return false;
    const PlaceCell& cell = search_.found()[at_].cell;
    Place& place = places_[at_];
    place = {};
    place.slot = at_;
    place.pose.p = map_.position_m(cell);
    place.pose.q =
        rt::normalised(rt::exp_rotation({0, 0, PlaceSearch::turn_rad(cell.turn)}) * q_level_sensor_);
    match_place(place, returns);
  }
  return true;
}

/// Those that did well, with more returns, then with all.
bool Relocaliser::run_retries(std::uint64_t& units) {
  const std::size_t returns = std::min<std::size_t>(size_, config_.tried_returns);
  for (; at_ < count_; ++at_) {
    if (!pay_match(3 * returns, units)) return false;
    match_place(places_[at_], returns);
    look_about(places_[at_]);
  }
  return true;
}

/// From starts about where a place ended: a rival that was caught beside its place would be no rival.
Match Relocaliser::look_about(Place& place) {
  Match match = registration_->match_from(place.pose, prior_at(place.pose), size_);
  registration_->match_about(match, prior_at(place.pose));
  keep(match, place);
  return match;
}

void Relocaliser::match_place(Place& place, std::size_t returns) {
  registration_->take_sample(sample());
  keep(registration_->match_from(place.pose, prior_at(place.pose), returns), place);
}

void Relocaliser::keep(const Match& match, Place& place) {
  place.pose = match.pose;
  place.weak = match.weak.moves + match.weak.turns > 0 || match.equations.rows < 6;
  explain(place);
}

/// By explained returns, most first; one that ended where a better one did is left out.
void Relocaliser::order() {
  std::sort(places_, places_ + count_, [](const Place& a, const Place& b) {
    return a.explained != b.explained ? a.explained > b.explained : a.slot < b.slot;
  });
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    bool other = true;
    for (std::uint32_t k = 0; k < kept; ++k)
      other = other && are_apart(places_[i].pose, places_[k].pose, kPlaceMove, kPlaceTurn);
    if (other) places_[kept++] = places_[i];
  }
  count_ = kept;
}

void Relocaliser::conclude(RelocateVerdict verdict) {
  RelocateCounts& counts = result_.counts;
  if (verdict == RelocateVerdict::placed) ++counts.placed;
  if (verdict == RelocateVerdict::ambiguous) ++counts.ambiguous;
  if (verdict == RelocateVerdict::nothing_fits) ++counts.nothing_fits;
  if (verdict == RelocateVerdict::few_returns) ++counts.few_returns;
  result_.verdict = verdict;
  step_ = Step::idle;
}

}  // namespace sortie::mapping
