// SPDX-License-Identifier: BSD-3-Clause
// Shifts that pairs agree on, and what pairs gain at a shift. Pairs themselves are in plane_candidates.cpp.
#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/registration/plane_candidates.hpp"
#include "mapping/registration/plane_patch.hpp"

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

constexpr double kWindow_m = 0.3;
constexpr double kLeastPeak = 0.4;  ///< of the best one's gain
}  // namespace

void PlaneCandidates::find_shifts(double scale, const PlaneEstimate& estimate) {
  scale_ = scale;
  voted_ = 0;
  for (std::uint32_t k = 0; k < size_; ++k) overlap_[k].reach[0] = kUnknown;
  for (std::uint32_t a = 0; a < axes_; ++a) vote(axis_[a], estimate);
  for (std::uint32_t a = 0; a < axes_; ++a) find_shadows(axis_[a]);
  for (auto& of_axis : given_) {
    for (auto& by_axis : of_axis) {
      for (auto& row : by_axis) std::fill(std::begin(row), std::end(row), -1.0);
    }
  }
  invert_axes(estimate);
  other_count_ = 0;
  for (std::uint32_t i = 0; i < source_->size(); ++i) {
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) {
      const std::uint16_t j = target_of_[k];
      const std::uint8_t f = target_->family(j);
      bool among = false;
      for (std::uint32_t a = 0; a < axes_; ++a) among = among || axis_[a].family == f;
      if (among) continue;
      others_[other_count_++] = k;
      offset_[k] = dot((*target_)[j].normal, centred_[j] - scale * rotated_[i].centroid);
      tally_.add(source_of_[k], j, gain_[k]);
    }
  }
  rest_gain_ = tally_.take(source_->size() <= target_->size(), rest_planes_);
}

void PlaneCandidates::vote(ShiftAxis& axis, const PlaneEstimate& estimate) {
  // The most that sides can be shifted against each other and still meet.
  const double most =
      0.5 * (target_->extent_m(axis.axis) + scale_ * source_->extent_m(rt::rotate_back(q_, axis.axis))) + 1.0;
  const PlanePose& given = estimate.T_target_source;
  const double expected = dot(axis.axis, transform(given, source_->middle_m()) - target_->middle_m());
  const double within = estimate.has_position() ? 4.0 * estimate.sigma_position_m + kWindow_m : 1e12;
  axis.first = voted_;
  for (std::uint32_t k = 0; k < size_; ++k) {
    if (target_->family(target_of_[k]) != axis.family) continue;
    const double at = dot(axis.axis, centred_[target_of_[k]] - scale_ * rotated_[source_of_[k]].centroid);
    if (std::fabs(at - expected) > within || std::fabs(at) > most) continue;
    votes_[voted_++] = {at, k, {}, {}};
  }
  axis.pairs = voted_ - axis.first;
  std::sort(votes_ + axis.first, votes_ + voted_, [](const Vote& a, const Vote& b) {
    return a.at_m != b.at_m ? a.at_m < b.at_m : a.pair < b.pair;
  });
  find_peaks(axis);
}

/// Windows that begin at a pair; most gain first, none that overlaps one taken before.
void PlaneCandidates::find_peaks(ShiftAxis& axis) {
  const Vote* const votes = votes_ + axis.first;
  const std::uint32_t n = axis.pairs;
  sums_[0] = 0.0;
  for (std::uint32_t k = 0; k < n; ++k) sums_[k + 1] = sums_[k] + gain_[votes[k].pair];
  rt::FixedVector<ShiftPeak, kMostShiftPeaks>& peaks = axis.peaks;
  peaks.clear();
  const auto put = [&peaks](const ShiftPeak& peak) {
    for (std::uint32_t k = 0; k < peaks.size(); ++k) {  // one of its own group: the better one stays
      if (peaks[k].end <= peak.first || peak.end <= peaks[k].first) continue;
      if (peaks[k].gain >= peak.gain) return;
    }
    for (std::uint32_t k = peaks.size(); k-- > 0;) {
      if (peaks[k].end > peak.first && peak.end > peaks[k].first) peaks.erase(k);
    }
    if (peaks.full()) {
      if (peaks.back().gain >= peak.gain) return;
      peaks.pop_back();
    }
    std::uint32_t at = peaks.size();
    (void)peaks.push_back(peak);
    for (; at > 0 && peaks[at - 1].gain < peak.gain; --at) peaks[at] = peaks[at - 1];
    peaks[at] = peak;
  };
  std::uint32_t end = 0;
  for (std::uint32_t first = 0; first < n; ++first) {
    const std::uint32_t before = end;
    while (end < n && votes[end].at_m <= votes[first].at_m + kWindow_m) ++end;
    if (first > 0 && end == before) continue;  // part of the window before
    put({0.0, sums_[end] - sums_[first], axis.first + first, axis.first + end, 0});
  }
  for (ShiftPeak& peak : peaks) {
    double weight = 0.0;
    double moment = 0.0;
    for (std::uint32_t k = peak.first; k < peak.end; ++k) {
      const std::uint32_t pair = votes_[k].pair;
      const double gain = gain_[pair];
      tally_.add(source_of_[pair], target_of_[pair], gain);
      weight += gain + 1e-9;
      moment += (gain + 1e-9) * (votes_[k].at_m - votes_[peak.first].at_m);
    }
    peak.gain = tally_.take(source_->size() <= target_->size(), peak.planes);
    peak.at_m = votes_[peak.first].at_m + moment / weight;
  }
  for (std::uint32_t i = 1; i < peaks.size(); ++i) {
    for (std::uint32_t k = i; k > 0 && peaks[k - 1].gain < peaks[k].gain; --k)
      std::swap(peaks[k - 1], peaks[k]);
  }
  while (!peaks.empty() && peaks.back().gain < kLeastPeak * peaks[0].gain) peaks.pop_back();
}

void PlaneCandidates::Tally::add(std::uint16_t source, std::uint16_t target, double gain) {
  if (!(gain > 0.0)) return;
  if (by_source_[source] == 0.0) sources_[source_count_++] = source;
  if (by_target_[target] == 0.0) targets_[target_count_++] = target;
  by_source_[source] = std::max(by_source_[source], gain);
  by_target_[target] = std::max(by_target_[target], gain);
}

double PlaneCandidates::Tally::take(bool of_source, std::uint32_t& planes) {
  double sources = 0.0;
  double targets = 0.0;
  for (std::uint32_t k = 0; k < source_count_; ++k) sources += std::exchange(by_source_[sources_[k]], 0.0);
  for (std::uint32_t k = 0; k < target_count_; ++k) targets += std::exchange(by_target_[targets_[k]], 0.0);
  planes = of_source ? source_count_ : target_count_;
  source_count_ = target_count_ = 0;
  return std::min(sources, targets);
}

/// Shadows of the rectangles of an axis' peaks on the other axes. Rectangles that overlap but for a margin
/// along their own sides may be further apart along others: by less than 1.5 margins.
void PlaneCandidates::find_shadows(const ShiftAxis& axis) {
  for (const ShiftPeak& peak : axis.peaks) {
    for (std::uint32_t k = peak.first; k < peak.end; ++k) {
      Vote& vote = votes_[k];
      const std::uint16_t j = target_of_[vote.pair];
      const Plane& t = (*target_)[j];
      const Rotated& s = rotated_[source_of_[vote.pair]];
      const PlanePatch own = own_patch(t);
      const Vector3 middle =
          scale_ * s.middle - centred_[j] - own.centre[0] * t.axis_u - own.centre[1] * across_[j];
      for (std::uint32_t b = 0; b < axes_; ++b) {
        const Vector3& n = axis_[b].axis;
        vote.apart_m[b] = static_cast<float>(dot(n, middle));
        vote.reach_m[b] = static_cast<float>(1.5 * margin_m_ + own.a[0] * std::fabs(dot(n, t.axis_u)) +
                                             own.b[1] * std::fabs(dot(n, across_[j])) +
                                             scale_ * (std::fabs(dot(n, s.a)) + std::fabs(dot(n, s.b))));
      }
    }
  }
}

double PlaneCandidates::gain_given(std::uint32_t a, std::uint32_t i, std::uint32_t b, std::uint32_t j) {
  double& known = given_[a][b][i][j];
  if (known >= 0.0) return known;
  const ShiftPeak& peak = axis_[a].peaks[i];
  const auto shift = static_cast<float>(axis_[b].peaks[j].at_m);
  for (std::uint32_t k = peak.first; k < peak.end; ++k) {
    const Vote& vote = votes_[k];
    if (std::fabs(vote.apart_m[b] + shift) <= vote.reach_m[b])
      tally_.add(source_of_[vote.pair], target_of_[vote.pair], gain_[vote.pair]);
  }
  std::uint32_t planes = 0;
  known = tally_.take(true, planes);
  return known;
}

void PlaneCandidates::prepare(std::uint32_t pair) {
  const std::uint16_t j = target_of_[pair];
  const Plane& t = (*target_)[j];
  const Rotated& s = rotated_[source_of_[pair]];
  const PlanePatch own = own_patch(t);
  const Vector3 middle = scale_ * s.middle - centred_[j];
  const Vector3& u = t.axis_u;
  const Vector3& v = across_[j];
  const double a[2] = {scale_ * dot(s.a, u), scale_ * dot(s.a, v)};
  const double b[2] = {scale_ * dot(s.b, u), scale_ * dot(s.b, v)};
  Overlap& o = overlap_[pair];
  o.u = static_cast<float>(dot(middle, u) - own.centre[0]);
  o.v = static_cast<float>(dot(middle, v) - own.centre[1]);
  o.reach[0] = static_cast<float>(own.a[0] + std::fabs(a[0]) + std::fabs(b[0]) + margin_m_);
  o.reach[1] = static_cast<float>(own.b[1] + std::fabs(a[1]) + std::fabs(b[1]) + margin_m_);
  const auto across = [&](const double(&side)[2], const double(&other)[2], float(&n)[2]) {
    const double length = std::sqrt(side[0] * side[0] + side[1] * side[1]);
    const double x = length > 0.0 ? -side[1] / length : 0.0;
    const double y = length > 0.0 ? side[0] / length : 0.0;
    n[0] = static_cast<float>(x);
    n[1] = static_cast<float>(y);
    return static_cast<float>(std::fabs(x * other[0] + y * other[1]) + std::fabs(x) * own.a[0] +
                              std::fabs(y) * own.b[1] + margin_m_);
  };
  o.reach[2] = across(a, b, o.across_a);
  o.reach[3] = across(b, a, o.across_b);
}

bool PlaneCandidates::overlaps(std::uint32_t pair, const rt::Vector3& t_m) {
  if (overlap_[pair].reach[0] == kUnknown) prepare(pair);
  const Overlap& o = overlap_[pair];
  const std::uint16_t j = target_of_[pair];
  const float u = o.u + static_cast<float>(dot(t_m, (*target_)[j].axis_u));
  const float v = o.v + static_cast<float>(dot(t_m, across_[j]));
  return std::fabs(u) <= o.reach[0] && std::fabs(v) <= o.reach[1] &&
         std::fabs(o.across_a[0] * u + o.across_a[1] * v) <= o.reach[2] &&
         std::fabs(o.across_b[0] * u + o.across_b[1] * v) <= o.reach[3];
}

ShiftLook PlaneCandidates::look_at(const rt::Vector3& t_m, const std::uint32_t (&peak)[3], double least) {
  const bool of_source = source_->size() <= target_->size();
  ShiftLook look;
  double possible = rest_gain_;
  for (std::uint32_t a = 0; a < axes_; ++a) possible += axis_[a].peaks[peak[a]].gain;
  for (std::uint32_t a = 0; a < axes_; ++a) {
    const ShiftPeak& p = axis_[a].peaks[peak[a]];
    for (std::uint32_t k = p.first; k < p.end; ++k) {
      const std::uint32_t pair = votes_[k].pair;
      if (overlaps(pair, t_m)) tally_.add(source_of_[pair], target_of_[pair], gain_[pair]);
    }
    std::uint32_t planes = 0;
    look.of_axis[a] = tally_.take(of_source, planes);
    look.gain += look.of_axis[a];
    look.matched += planes;
    possible += look.of_axis[a] - p.gain;
    if (possible > least) continue;
    look.gain = possible;
    return look;
  }
  double along[kMostPlanes];  // of the shift, each target's normal
  if (other_count_ > 0) {
    for (std::uint32_t j = 0; j < target_->size(); ++j) along[j] = dot((*target_)[j].normal, t_m);
  }
  for (std::uint32_t k = 0; k < other_count_; ++k) {
    const std::uint32_t pair = others_[k];
    const double residual = along[target_of_[pair]] - offset_[pair];
    if (std::fabs(residual) <= gate_m_ && overlaps(pair, t_m))
      tally_.add(source_of_[pair], target_of_[pair], gain_[pair]);
  }
  std::uint32_t planes = 0;
  look.gain += tally_.take(of_source, planes);
  look.matched += planes;
  look.whole = true;
  return look;
}

std::uint32_t PlaneCandidates::covered_at(const rt::Vector3& t_m, std::uint32_t enough) const {
  const bool of_source = source_->size() <= target_->size();
  const std::uint32_t n = of_source ? source_->size() : target_->size();
  if (enough > n) enough = n + 1;  // all are counted
  const Vector3 half = of_source ? target_->half_m() : scale_ * source_->half_m();
  const Vector3 back = of_source ? t_m : rt::rotate_back(q_, t_m);
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < n && count < enough; ++i) {
    const Vector3 d = of_source ? scale_ * rotated_[i].centroid + back : turned_back_[i] - back;
    count += static_cast<std::uint32_t>((std::fabs(d.x) <= half.x) & (std::fabs(d.y) <= half.y) &
                                        (std::fabs(d.z) <= half.z));
  }
  return count;
}

}  // namespace sortie::mapping
