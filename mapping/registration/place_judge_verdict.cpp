// SPDX-License-Identifier: BSD-3-Clause
// Whether a place is believed: by what it explains, and by what other places explain instead.
#include <algorithm>
#include <bit>

#include "mapping/registration/match_covariance.hpp"
#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/place_rays.hpp"

namespace sortie::mapping {
namespace {
constexpr double kMostMove = 0.015;  ///< m and rad, standard deviations: of a place that is held
constexpr double kMostTurn = 0.006;
constexpr double kNear2 = 9.0;  ///< squared standard deviations from a surface

/// Whether a point of the map's frame lies on the surface of its cell; `known`: there is one.
bool on_surface(const SurfelLayer& layer, const rt::Vector3& p, const rt::Vector3& ray, double sigma_m,
                bool& known) {
  SurfelPlace place;
  known = false;
  if (!layer.place(p.x, p.y, p.z, place)) return false;
  const Surfel* const surfel = layer.surfel_met(place.cell, ray);
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

void PlaceJudge::explain(Place& place) {
  const SurfelLayer& fine = registration_->layer(0);
  const SurfelLayer& coarse = registration_->layer(kSurfelLayers - 1);
  const double sigma_m = registration_->config().sigma_m;
  std::uint64_t* const explained = explained_bits(place);
  std::uint64_t* const known = known_bits(place);
  std::fill_n(explained, 3 * words(), std::uint64_t{0});
  place.explained = place.seen = place.through = 0;
  const rt::RotationMatrix r = rt::to_matrix(place.pose.q);
  for (std::uint32_t i = 0; i < size_; ++i) {
    const rt::Vector3 p = r * sample_[i].at() + place.pose.p;
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    if (!is_seen(coarse, p)) continue;
    ++place.seen;
    bool has_surface{};
    const bool on = on_surface(fine, p, p - place.pose.p, sigma_m, has_surface);
    if (has_surface) known[i / 64] |= bit;
    if (!on) continue;
    explained[i / 64] |= bit;
    ++place.explained;
  }
}

/// After explain(): one ray in two for what it went through, each return that is not explained for what lies
/// behind it.
void PlaceJudge::look_along_rays(Place& place) {
  const SurfelLayer& fine = registration_->layer(0);
  const std::uint64_t* const explained = explained_bits(place);
  std::uint64_t* const known = known_bits(place);
  std::uint64_t* const crossed = crossed_bits(place);
  for (std::uint32_t i = 0; i < size_; ++i) {
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    const rt::Vector3 at = sample_[i].at();
    if (((explained[i / 64] | known[i / 64]) & bit) == 0 && is_before_surface(fine, place.pose, at))
      known[i / 64] |= bit;
    if (i % 2 != 0 || !goes_through(fine, place.pose, at)) continue;
    crossed[i / 64] |= bit;
    ++place.through;
  }
}

/// What `here` explains and the other place does not speaks for it where the map knows that place, or the
/// rays of the other one went through surfaces; where that place has a gap in the map, a part of it.
PlaceJudge::Compared PlaceJudge::compare(const Place& here, const Place& there) const {
  struct Sums {
    std::uint64_t here{}, denied{}, there{};
  };
  Sums sums[kWeighed + 1];
  std::uint32_t crossed_here = 0, crossed_there = 0;
  const std::uint64_t* const a = explained_bits(here);
  const std::uint64_t* const b = explained_bits(there);
  const std::uint64_t* const known = known_bits(there);
  for (std::size_t i = 0; i < words(); ++i) {
    const std::uint64_t crossed[2] = {crossed_bits(here)[i], crossed_bits(there)[i]};
    crossed_here += static_cast<std::uint32_t>(std::popcount(crossed[0] & ~crossed[1]));
    crossed_there += static_cast<std::uint32_t>(std::popcount(crossed[1] & ~crossed[0]));
    for (std::uint64_t rest = a[i] ^ b[i]; rest != 0; rest &= rest - 1) {
      const int at = std::countr_zero(rest);
      const std::uint64_t bit = std::uint64_t{1} << at;
      const Weights& weights = weights_[64 * i + static_cast<std::size_t>(at)];
      const auto add = [&](std::uint64_t Sums::*sum) {
        ++(sums[0].*sum);
        for (std::size_t by = 0; by < kWeighed; ++by) sums[by + 1].*sum += weights.of[by];
      };
      add((a[i] & bit) != 0 ? &Sums::here : &Sums::there);
      if ((a[i] & known[i] & bit) != 0) add(&Sums::denied);
    }
  }
  Compared compared;
  for (std::size_t by = 0; by <= kWeighed; ++by) {
    const double all = by == 0 ? size_ : weight_[by - 1];
    const auto share = [&](std::uint64_t sum) { return static_cast<double>(sum) / all; };
    compared.by[by] = {share(sums[by].denied) + config_.of_gaps * share(sums[by].here - sums[by].denied) +
                           crossed_there / rays(),
                       share(sums[by].there) + crossed_here / rays()};
  }
  return compared;
}

/// Of the returns, the surfaces and the things, and rays that the place cannot explain. What the map has not
/// seen does not count.
void PlaceJudge::unexplained(const Place& place, double (&out)[kWeighed + 1]) const {
  std::uint64_t explained[kWeighed]{};
  for (std::uint32_t i = 0; i < size_; ++i) {
    if ((explained_bits(place)[i / 64] >> (i % 64) & 1) == 0) continue;
    for (std::size_t by = 0; by < kWeighed; ++by) explained[by] += weights_[i].of[by];
  }
  const double seen = place.seen / static_cast<double>(size_);
  for (std::size_t by = 0; by <= kWeighed; ++by) {
    const double share = by == 0 ? place.explained / static_cast<double>(size_)
                                 : static_cast<double>(explained[by - 1]) / weight_[by - 1];
    out[by] = std::max(0.0, seen - share) + place.through / rays();
  }
}

/// Things that were moved speak against all places alike, and against the right one too: what counts is how
/// much more speaks for this place than for each other one, and than against this one; by the returns, of
/// which one thing may have a third, by the surfaces that they lie on, and by the things. What all places
/// explain, walls of a room that looks the same from both ends, says nothing. A place that the map does not
/// know, in another building that looks alike but for a few things, cannot be compared with: against it
/// speaks only what this place leaves unexplained: where that is little, it is sure.
bool PlaceJudge::leads(const Place& best, JudgedPlace& judged) const {
  double without[kWeighed + 1];
  unexplained(best, without);
  bool leads = true;
  judged.lead = 1.0;
  judged.unexplained = *std::max_element(std::begin(without), std::end(without));
  judged.sure = judged.lead >= config_.least_lead + config_.surely_over_unexplained * judged.unexplained;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (places_[i].slot == best.slot) continue;
    const Compared compared = compare(best, places_[i]);
    for (std::size_t by = 0; by <= kWeighed; ++by) {
      const Evidence& evidence = compared.by[by];
      const double lead = evidence.speaks_for - evidence.against;
      leads = leads && evidence.speaks_for >= config_.over_rival * evidence.against &&
              lead >= config_.least_lead + config_.over_unexplained * without[by];
      judged.sure = judged.sure && lead >= config_.least_lead + config_.surely_over_unexplained * without[by];
      if (lead >= judged.lead) continue;
      judged.lead = lead;
      judged.denied = evidence.speaks_for;
      judged.rival = evidence.against;
    }
  }
  return leads;
}

RelocateVerdict PlaceJudge::judge(JudgedPlace& judged) {
  if (count_ == 0) return RelocateVerdict::nothing_fits;
  Place& best = places_[0];
  registration_->take_sample(sample());
  const Match match = look_about(best, prior_at(best.pose, kFreeTilt));
  look_along_rays(best);
  judged.T_map_sensor = best.pose;
  judged.share = best.seen > 0 ? best.explained / static_cast<double>(best.seen) : 0.0;
  judged.seen = best.seen / static_cast<double>(size_);
  judged.crossed = best.through / rays();
  const bool lead = leads(best, judged);
  if (judged.share < config_.least_share || judged.seen < config_.least_seen ||
      judged.crossed > config_.most_crossed)
    return RelocateVerdict::nothing_fits;
  if (!lead || best.weak) return RelocateVerdict::ambiguous;
  double covariance[6][6]{};
  if (!match_covariance(match.equations, match.weak, prior_at(best.pose, 10.0), match.spread, covariance))
    return RelocateVerdict::ambiguous;
  pose_covariance(covariance, best.pose.q, judged.covariance);
  const auto trace = [&](int at) {
    return judged.covariance[7 * at] + judged.covariance[7 * at + 7] + judged.covariance[7 * at + 14];
  };
  if (trace(0) > kMostMove * kMostMove || trace(3) > kMostTurn * kMostTurn) return RelocateVerdict::ambiguous;
  return RelocateVerdict::placed;
}

}  // namespace sortie::mapping
