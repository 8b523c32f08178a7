// SPDX-License-Identifier: BSD-3-Clause
// Whether a place is believed: by what it explains, and by what other places explain instead.
#include <algorithm>
#include <bit>

#include "mapping/registration/match_covariance.hpp"
#include "mapping/registration/relocaliser.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kJudgeRays = 256;
constexpr std::uint32_t kJudgeRaySteps = 96;
constexpr double kMostMove = 0.02;  ///< m and rad, standard deviations: of a place that is held
constexpr double kMostTurn = 0.006;
constexpr double kNear2 = 9.0;  ///< squared standard deviations from a surface

/// Whether a point of the map's frame lies on the surface of its cell; `known`: there is one.
bool on_surface(const SurfelLayer& layer, const rt::Vector3& p, double sigma_m, bool& known) {
  SurfelPlace place;
  known = false;
  if (!layer.place(p.x, p.y, p.z, place)) return false;
  const Surfel* const surfel = layer.surfel_at(place.cell);
  if (surfel == nullptr) return false;
  known = true;
  return squared_deviations(*surfel, layer.from_centre_m(place), sigma_m * sigma_m) < kNear2;
}

/// The map has seen something within two metres or so.
bool is_seen(const SurfelLayer& coarse, const rt::Vector3& p) {
  SurfelPlace place;
  return coarse.place(p.x, p.y, p.z, place) && coarse.find(place.cell) != kNoSurfel;
}
}  // namespace

void Relocaliser::explain(Place& place) {
  const SurfelLayer& fine = registration_->layer(0);
  const SurfelLayer& coarse = registration_->layer(kSurfelLayers - 1);
  const double sigma_m = registration_->config().sigma_m;
  std::uint64_t* const explained = explained_bits(place);
  std::uint64_t* const known = known_bits(place);
  std::fill_n(explained, 2 * words(), std::uint64_t{0});
  place.explained = place.seen = 0;
  const rt::RotationMatrix r = rt::to_matrix(place.pose.q);
  for (std::uint32_t i = 0; i < size_; ++i) {
    const rt::Vector3 p = r * sample_[i].at() + place.pose.p;
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    if (!is_seen(coarse, p)) continue;
    ++place.seen;
    bool has_surface{};
    const bool on = on_surface(fine, p, sigma_m, has_surface);
    if (has_surface) known[i / 64] |= bit;
    if (!on) continue;
    explained[i / 64] |= bit;
    ++place.explained;
  }
  place.through = rays_through_surfaces(fine, sample(), place.pose, kJudgeRays, kJudgeRaySteps);
}

Relocaliser::Compared Relocaliser::compare(const Place& here, const Place& there) const {
  const std::uint64_t* const a = explained_bits(here);
  const std::uint64_t* const b = explained_bits(there);
  const std::uint64_t* const known = known_bits(there);
  Compared compared;
  const auto count = [](std::uint64_t word) { return static_cast<std::uint32_t>(std::popcount(word)); };
  for (std::size_t i = 0; i < words(); ++i) {
    compared.here += count(a[i] & ~b[i]);
    compared.denied += count(a[i] & ~b[i] & known[i]);
    compared.there += count(b[i] & ~a[i]);
  }
  return compared;
}

/// No other place explains what this one does not, to speak of, and this one much that each other does not.
/// What all of them explain, walls of a room that looks the same from both ends, says nothing; and where
/// more is left unexplained than speaks for the place, its lead may be chance.
bool Relocaliser::leads(const Place& best) {
  bool leads = true;
  result_.lead = 1.0;
  result_.unexplained = (best.seen - best.explained) / static_cast<double>(size_);
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (places_[i].slot == best.slot) continue;
    const Compared compared = compare(best, places_[i]);
    const double here = compared.here / static_cast<double>(size_);
    const double denied = compared.denied / static_cast<double>(size_);
    const double there = compared.there / static_cast<double>(size_);
    if (here < result_.lead) {
      result_.lead = here;
      result_.rival = there;
      result_.denied = denied;
    }
    // What lies where the other place has no surface at all may lie in a gap of the map.
    leads = leads && here >= config_.least_lead && denied >= config_.least_denied &&
            denied >= config_.over_rival * there && here >= config_.over_unexplained * result_.unexplained;
  }
  return leads;
}

RelocateVerdict Relocaliser::judge() {
  if (count_ == 0) return RelocateVerdict::nothing_fits;
  Place& best = places_[0];
  const PosePrior prior = prior_at(best.pose);
  registration_->take_sample(sample());
  const Match match = look_about(best);
  result_.T_map_sensor = best.pose;
  result_.share = best.seen > 0 ? best.explained / static_cast<double>(best.seen) : 0.0;
  result_.seen = best.seen / static_cast<double>(size_);
  result_.crossed = best.through / static_cast<double>(std::min(kJudgeRays, size_));
  const bool lead = leads(best);
  if (result_.share < config_.least_share || result_.seen < config_.least_seen ||
      result_.crossed > config_.most_crossed)
    return RelocateVerdict::nothing_fits;
  if (!lead || best.weak) return RelocateVerdict::ambiguous;
  double covariance[6][6]{};
  if (!match_covariance(match.equations, match.weak, prior, match.spread, covariance))
    return RelocateVerdict::ambiguous;
  pose_covariance(covariance, best.pose.q, result_.covariance);
  const auto trace = [&](int at) {
    return result_.covariance[7 * at] + result_.covariance[7 * at + 7] + result_.covariance[7 * at + 14];
  };
  if (trace(0) > kMostMove * kMostMove || trace(3) > kMostTurn * kMostTurn) return RelocateVerdict::ambiguous;
  return RelocateVerdict::placed;
}

}  // namespace sortie::mapping
