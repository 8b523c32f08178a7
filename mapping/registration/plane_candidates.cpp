// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_patch.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

constexpr double kHalfLog2Pi = 0.91893853320467;
constexpr int kShiftBins = 2048;
constexpr double kBin_m = 0.1;
constexpr double kGainStep = 1.0 / 256.0;  ///< votes are whole numbers
}  // namespace

void PlaneCandidates::pair_up(const PlaneSide& source, const PlaneSide& target, const rt::Quaternion& q,
                              const PlaneRegistrationConfig& config) {
  source_ = &source;
  target_ = &target;
  q_ = q;
  size_ = 0;
  dropped_ = 0;
  gate_m_ = config.search_gate_m;
  margin_m_ = config.overlap_margin_m;
  const rt::RotationMatrix r = rt::to_matrix(q);
  const double least_cosine = rt::cos(config.most_angle_rad);
  const double log_share = rt::log(config.share_matched);
  for (std::uint32_t j = 0; j < target.size(); ++j) centred_[j] = target[j].centroid_m - target.middle_m();
  for (std::uint32_t i = 0; i < source.size(); ++i) {
    const Plane& s = source[i];
    const Vector3 n = r * s.normal;
    const Vector3 u = r * s.axis_u;
    const Vector3 v = rt::cross(n, u);
    const PlanePatch own = own_patch(s);
    Rotated& rotated = rotated_[i];
    rotated.centroid = r * (s.centroid_m - source.middle_m());
    rotated.middle = rotated.centroid + own.centre[0] * u + own.centre[1] * v;
    rotated.a = own.a[0] * u;
    rotated.b = own.b[1] * v;
    first_[i] = size_;
    for (std::uint32_t j = 0; j < target.size(); ++j) {
      const Plane& t = target[j];
      const double along = dot(n, t.normal);
      const bool opposite = along < 0.0;
      if ((opposite ? -along : along) < least_cosine || (opposite && config.signed_normals)) continue;
      if (s.area_m2 > config.most_area_ratio * t.area_m2 || t.area_m2 > config.most_area_ratio * s.area_m2) continue;
      if (size_ == kMostCandidatePairs) {
        ++dropped_;
        continue;
      }
      source_of_[size_] = static_cast<std::uint16_t>(i);
      target_of_[size_] = static_cast<std::uint16_t>(j);
      opposite_[size_] = opposite;
      worth_[size_] = target.log_extent(j) - kHalfLog2Pi + log_share;
      ++size_;
    }
    const double chances = rt::log(static_cast<double>(std::max(1u, size_ - first_[i])));
    for (std::uint32_t k = first_[i]; k < size_; ++k) {
      worth_[k] -= chances;
      const double sigma = std::max(source.log_sigma(i), target.log_sigma(target_of_[k]));
      gain_[k] = std::max(0.0, worth_[k] - std::max(sigma, rt::log(config.fit.model_sigma_m)));
    }
  }
  first_[source.size()] = size_;
  choose_axes();
}

void PlaneCandidates::choose_axes() {
  double weight[kMostFamilies]{};
  for (std::uint32_t k = 0; k < size_; ++k) {
    const std::uint8_t f = target_->family(target_of_[k]);
    if (f != PlaneSide::kNoFamily) weight[f] += gain_[k];
  }
  axes_ = 0;
  while (axes_ < 3) {
    int best = -1;
    for (std::uint32_t f = 0; f < target_->families(); ++f) {
      const Vector3& a = target_->family_axis(f);
      bool apart = weight[f] > 0.0;
      if (axes_ == 1) apart = apart && std::fabs(dot(a, axis_[0].axis)) < 0.94;  // 20 degrees
      if (axes_ == 2) apart = apart && std::fabs(dot(a, rt::cross(axis_[0].axis, axis_[1].axis))) > 0.3;
      if (apart && (best < 0 || weight[f] > weight[best])) best = static_cast<int>(f);
    }
    if (best < 0) break;
    axis_[axes_].axis = target_->family_axis(static_cast<std::uint32_t>(best));
    axis_[axes_].family = static_cast<std::uint8_t>(best);
    ++axes_;
  }
}

void PlaneCandidates::find_scales(const PlaneEstimate& estimate, rt::FixedVector<double, 8>& scales) const {
  constexpr int kScaleBins = 512;
  constexpr double kStep = 0.0025;
  constexpr std::uint32_t kMostPairs = 96;
  scales.clear();
  const double given = rt::log(estimate.T_target_source.scale);
  const int half = std::clamp(static_cast<int>(3.0 * estimate.sigma_scale / kStep), 1, kScaleBins / 2 - 2);
  double votes[kScaleBins]{};
  double moments[kScaleBins]{};
  for (std::uint32_t a = 0; a < axes_; ++a) {
    double from[kMostPairs];
    double to[kMostPairs];
    std::uint16_t s[kMostPairs];
    std::uint16_t t[kMostPairs];
    std::uint32_t count = 0;
    for (std::uint32_t k = 0; k < size_ && count < kMostPairs; ++k) {
      if (target_->family(target_of_[k]) != axis_[a].family) continue;
      s[count] = source_of_[k];
      t[count] = target_of_[k];
      from[count] = dot(axis_[a].axis, rotated_[s[count]].centroid);
      to[count] = dot(axis_[a].axis, centred_[t[count]]);
      ++count;
    }
    for (std::uint32_t k = 0; k < count; ++k) {
      for (std::uint32_t l = k + 1; l < count; ++l) {
        const double d_from = from[k] - from[l];
        const double d_to = to[k] - to[l];
        if (s[k] == s[l] || t[k] == t[l] || std::fabs(d_from) < 1.5 || !(d_to * d_from > 0.0)) continue;
        const double ratio = d_to / d_from;
        if (ratio < 0.25 || ratio > 4.0) continue;
        const double at = (rt::log(ratio) - given) / kStep + half + 0.5;
        if (at < 0.0 || at >= 2 * half + 1) continue;
        const int bin = static_cast<int>(at);
        const double w = std::min(std::fabs(d_from), 20.0);
        votes[bin] += w;
        moments[bin] += w * at;
      }
    }
  }
  while (scales.size() < 6) {
    int best = -1;
    double most = 0.0;
    for (int bin = 0; bin < 2 * half + 1; ++bin) {
      const double sum = (bin > 0 ? votes[bin - 1] : 0.0) + votes[bin] + votes[bin + 1];
      if (sum > most && votes[bin] > 0.0) most = sum, best = bin;
    }
    if (best < 0) break;
    double moment = 0.0;
    for (int bin = std::max(0, best - 1); bin <= best + 1; ++bin) moment += moments[bin];
    (void)scales.push_back(rt::exp(given + kStep * (moment / most - half - 0.5)));
    for (int bin = std::max(0, best - 1); bin <= best + 1; ++bin) votes[bin] = moments[bin] = 0.0;
  }
  if (scales.empty()) (void)scales.push_back(estimate.T_target_source.scale);
}

void PlaneCandidates::find_shifts(double scale, const PlaneEstimate& estimate,
                                  const PlaneRegistrationConfig& config) {
  (void)config;
  scale_ = scale;
  for (std::uint32_t k = 0; k < size_; ++k) {
    const std::uint16_t j = target_of_[k];
    offset_[k] = dot((*target_)[j].normal, centred_[j] - scale * rotated_[source_of_[k]].centroid);
  }
  for (std::uint32_t a = 0; a < axes_; ++a) vote(axis_[a], estimate);
  invert_axes(estimate);
  rest_gain_ = 0.0;
  for (std::uint32_t i = 0; i < source_->size(); ++i) {
    double best = 0.0;
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) {
      const std::uint8_t f = target_->family(target_of_[k]);
      bool among = false;
      for (std::uint32_t a = 0; a < axes_; ++a) among = among || axis_[a].family == f;
      if (!among) best = std::max(best, gain_[k]);
    }
    rest_gain_ += best;
  }
}

void PlaneCandidates::vote(ShiftAxis& axis, const PlaneEstimate& estimate) {
  std::int32_t votes[kShiftBins]{};
  std::int64_t moments[kShiftBins]{};
  // The most that sides can be shifted against each other and still meet.
  const double most = 0.5 * (target_->extent_m(axis.axis) + scale_ * source_->extent_m(
                                 rt::rotate_back(q_, axis.axis))) + 1.0;
  const double width = std::max(kBin_m, 2.0 * most / (kShiftBins - 8));
  const PlanePose& given = estimate.T_target_source;
  const double expected = dot(axis.axis, transform(given, source_->middle_m()) - target_->middle_m());
  const double within = estimate.has_position() ? 3.0 * estimate.sigma_position_m + 3.0 * kBin_m : 1e12;
  axis.pairs = 0;
  int low = kShiftBins;
  int high = 0;
  for (std::uint32_t k = 0; k < size_; ++k) {
    if (target_->family(target_of_[k]) != axis.family) continue;
    const double at = dot(axis.axis, centred_[target_of_[k]] - scale_ * rotated_[source_of_[k]].centroid);
    if (std::fabs(at - expected) > within || std::fabs(at) > most) continue;
    ++axis.pairs;
    const double place = (at + most) / width + 2.0;
    const int bin = static_cast<int>(place);
    const auto weight = static_cast<std::int32_t>(gain_[k] / kGainStep) + 1;
    votes[bin] += weight;
    moments[bin] += static_cast<std::int64_t>(weight) * static_cast<std::int32_t>((place - bin) * 1024.0);
    low = std::min(low, bin);
    high = std::max(high, bin);
  }
  axis.peaks.clear();
  while (!axis.peaks.full()) {
    std::int32_t best = 0;
    int at = -1;
    for (int bin = low; bin <= high; ++bin) {
      if (votes[bin] == 0) continue;
      const std::int32_t sum = votes[bin - 1] + votes[bin] + votes[bin + 1];
      if (sum > best) best = sum, at = bin;
    }
    if (at < 0) break;
    std::int64_t moment = 0;
    for (int k = -1; k <= 1; ++k) {
      moment += moments[at + k] + k * 1024 * static_cast<std::int64_t>(votes[at + k]);
      votes[at + k] = 0;
      moments[at + k] = 0;
    }
    const double place = at + static_cast<double>(moment) / (1024.0 * best);
    (void)axis.peaks.push_back({(place - 2.0) * width - most, best * kGainStep});
  }
}

void PlaneCandidates::invert_axes(const PlaneEstimate& estimate) {
  // Directions that no axis has are square to those that are there; they keep the estimate.
  Vector3 a[3];
  for (std::uint32_t k = 0; k < axes_; ++k) a[k] = axis_[k].axis;
  if (axes_ == 0) a[0] = {1, 0, 0};
  if (axes_ <= 1) {
    const Vector3 other = std::fabs(a[0].z) < 0.7 ? Vector3{0, 0, 1} : Vector3{1, 0, 0};
    const Vector3 square = rt::cross(a[0], other);
    a[1] = (1.0 / rt::norm(square)) * square;
  }
  if (axes_ <= 2) {
    const Vector3 square = rt::cross(a[0], a[1]);
    a[2] = (1.0 / rt::norm(square)) * square;
  }
  const double det = dot(a[0], rt::cross(a[1], a[2]));
  for (int k = 0; k < 3; ++k) dual_[k] = (1.0 / det) * rt::cross(a[(k + 1) % 3], a[(k + 2) % 3]);
  const Vector3 expected = transform(estimate.T_target_source, source_->middle_m()) - target_->middle_m();
  rest_ = {};
  if (estimate.has_position()) {
    for (std::uint32_t k = axes_; k < 3; ++k) rest_ = rest_ + dot(a[k], expected) * dual_[k];
  }
}

rt::Vector3 PlaneCandidates::shift(const double (&along)[3]) const {
  Vector3 t = rest_;
  for (std::uint32_t k = 0; k < axes_; ++k) t = t + along[k] * dual_[k];
  return t;
}

PlanePose PlaneCandidates::pose(const rt::Vector3& t_m) const {
  PlanePose pose{q_, {}, scale_};
  pose.p_target_source_m = target_->middle_m() + t_m - scale_ * rt::rotate(q_, source_->middle_m());
  return pose;
}

double PlaneCandidates::gain_at(const rt::Vector3& t_m, std::uint32_t& matched) {
  std::uint16_t touched[kMostPlanes];
  std::uint32_t count = 0;
  const std::uint32_t n = source_->size();
  for (std::uint32_t i = 0; i < n; ++i) {
    double most = 0.0;
    std::uint32_t which = 0;
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) {
      const std::uint16_t j = target_of_[k];
      const Plane& t = (*target_)[j];
      const double residual = dot(t.normal, t_m) - offset_[k];
      if (std::fabs(residual) > gate_m_ || gain_[k] <= most) continue;
      const Rotated& s = rotated_[i];
      const Vector3 middle = scale_ * s.middle + t_m - centred_[j];
      const Vector3 v = t.axis_v();
      const PlanePatch p{{dot(middle, t.axis_u), dot(middle, v)},
                         {scale_ * dot(s.a, t.axis_u), scale_ * dot(s.a, v)},
                         {scale_ * dot(s.b, t.axis_u), scale_ * dot(s.b, v)}};
      if (!overlap(own_patch(t), p, margin_m_)) continue;
      most = gain_[k];
      which = k;
    }
    if (most == 0.0) continue;
    const std::uint16_t j = target_of_[which];
    if (best_[j] == 0.0) touched[count++] = j;
    best_[j] = std::max(best_[j], most);
  }
  double sum = 0.0;
  for (std::uint32_t k = 0; k < count; ++k) {
    sum += best_[touched[k]];
    best_[touched[k]] = 0.0;
  }
  matched = count;
  return sum;
}

}  // namespace sortie::mapping
