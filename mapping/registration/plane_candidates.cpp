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
constexpr double kMostCover = 0.69314718055994531;  ///< ln 2: what covering each other adds at most
}  // namespace

PlaneCandidates::PlaneCandidates() {
  for (std::uint32_t n = 1; n <= kMostPlanes; ++n) log_count_[n] = rt::log(static_cast<double>(n));
}

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
  const double least_sigma = rt::log(config.fit.model_sigma_m);
  for (std::uint32_t j = 0; j < target.size(); ++j) {
    centred_[j] = target[j].centroid_m - target.middle_m();
    across_[j] = target[j].axis_v();
    if (target.size() < source.size()) turned_back_[j] = rt::rotate_back(q, centred_[j]);
  }
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
    std::uint16_t near[kMostPlanes];
    const std::uint32_t count = target.near_normals(n, least_cosine, config.signed_normals, near);
    for (std::uint32_t c = 0; c < count; ++c) {
      const std::uint16_t j = near[c];
      const double area = target[j].area_m2;
      if (s.area_m2 > config.most_area_ratio * area || area > config.most_area_ratio * s.area_m2) continue;
      if (size_ == kMostCandidatePairs) {
        ++dropped_;
        continue;
      }
      source_of_[size_] = static_cast<std::uint16_t>(i);
      target_of_[size_] = j;
      opposite_[size_] = !config.signed_normals && dot(n, target[j].normal) < 0.0;
      worth_[size_] = target.log_extent(j) - kHalfLog2Pi + log_share;
      ++size_;
    }
    const double chances = log_count_[size_ - first_[i]];
    for (std::uint32_t k = first_[i]; k < size_; ++k) {
      worth_[k] -= chances;
      const double sigma = std::max(source.log_sigma(i), target.log_sigma(target_of_[k]));
      gain_[k] = std::max(0.0, worth_[k] - std::max(sigma, least_sigma) + kMostCover);
    }
  }
  first_[source.size()] = size_;
  choose_axes();
}

void PlaneCandidates::choose_axes() {
  double weight[kMostFamilies]{};
  for (std::uint32_t k = 0; k < size_; ++k) {
    const std::uint8_t f = target_->family(target_of_[k]);
    if (f == PlaneSide::kNoFamily) continue;
    const double area = std::min((*source_)[source_of_[k]].area_m2, (*target_)[target_of_[k]].area_m2);
    weight[f] += gain_[k] * std::sqrt(std::min(area, 25.0));  // what is large is seen by both
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
  constexpr std::uint32_t kMostPairs = 192;
  scales.clear();
  const double given = estimate.T_target_source.scale;  // bins are parts of it
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
        const double at = (ratio / given - 1.0) / kStep + half + 0.5;
        if (!(at >= 0.0 && at < 2 * half + 1)) continue;
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
    (void)scales.push_back(given * (1.0 + kStep * (moment / most - half - 0.5)));
    for (int bin = std::max(0, best - 1); bin <= best + 1; ++bin) votes[bin] = moments[bin] = 0.0;
  }
  if (scales.empty()) (void)scales.push_back(estimate.T_target_source.scale);
}

void PlaneCandidates::invert_axes(const PlaneEstimate& estimate) {
  // Directions that no axis has are square to those that are there; they keep the estimate.
  Vector3 a[3];
  for (std::uint32_t k = 0; k < axes_; ++k) a[k] = axis_[k].axis;
  if (axes_ == 0) a[0] = {1, 0, 0};
  const auto square_to = [](const Vector3& first, const Vector3& second) {
    const Vector3 square = rt::cross(first, second);
    return (1.0 / rt::norm(square)) * square;
  };
  if (axes_ <= 1) a[1] = square_to(a[0], std::fabs(a[0].z) < 0.7 ? Vector3{0, 0, 1} : Vector3{1, 0, 0});
  if (axes_ <= 2) a[2] = square_to(a[0], a[1]);
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

}  // namespace sortie::mapping
