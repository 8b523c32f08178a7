// SPDX-License-Identifier: BSD-3-Clause
// Ways to say how unlike two segments look: the descriptor of the map, and the published features.
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "mapping/recognition/candidates.hpp"
#include "mapping/recognition/segment_shape.hpp"
#include "tests/bench/recognition/hall_visit.hpp"

namespace sortie::bench {

/// The ways, in the order of the tables.
enum class Likeness {
  gated,  ///< as candidates are found: what is not within the gate is infinitely far
  steps,  ///< without the gate
  alike,  ///< with the gate, all steps count once
  features,
  features_and_sizes,
};
inline constexpr Likeness kLikenesses[] = {Likeness::gated, Likeness::steps, Likeness::alike,
                                           Likeness::features, Likeness::features_and_sizes};
inline std::string name_of(Likeness likeness) {
  switch (likeness) {
    case Likeness::gated:
      return "24 bytes, gate of sizes";
    case Likeness::steps:
      return "24 bytes";
    case Likeness::alike:
      return "24 bytes, each once, gate";
    case Likeness::features:
      return "seven features";
    default:
      return "seven features and sizes";
  }
}

/// Distances of segments. The features of M. Weinmann et al. are divided by their spread over a set of
/// segments, and compared by Euclidean distance; the sizes beside them are logarithms of the spreads along
/// the principal axes, divided likewise.
class SegmentLikeness {
 public:
  static constexpr std::size_t kFeatures = 7, kAll = kFeatures + 3;

  /// `set`: what the spread is taken from, more than one.
  explicit SegmentLikeness(const std::vector<const SpokenSegment*>& set) {
    double sum[kAll]{}, square[kAll]{};
    for (const SpokenSegment* const segment : set) {
      double value[kAll];
      list(segment->features, value);
      for (std::size_t i = 0; i < kAll; ++i) {
        sum[i] += value[i];
        square[i] += value[i] * value[i];
      }
    }
    const double n = static_cast<double>(set.size());
    for (std::size_t i = 0; i < kAll; ++i)
      per_spread_[i] = 1.0 / std::sqrt(std::max(square[i] / n - sum[i] * sum[i] / (n * n), 1e-12));
  }

  double distance(Likeness by, const SpokenSegment& a, const SpokenSegment& b) const {
    if (by == Likeness::features || by == Likeness::features_and_sizes)
      return of_features(a, b, by == Likeness::features ? kFeatures : kAll);
    const auto steps = static_cast<std::int32_t>(mapping::CandidateConfig{}.size_steps);
    if (by != Likeness::steps && !mapping::same_sizes(a.descriptor, b.descriptor, steps))
      return std::numeric_limits<double>::infinity();
    const double apart = mapping::difference(a.descriptor, b.descriptor);
    if (by != Likeness::alike) return apart;
    constexpr unsigned k = mapping::SegmentDescriptor::kSize;
    const std::uint8_t(&s)[24] = a.descriptor.step, (&t)[24] = b.descriptor.step;
    return apart - (mapping::kSizeWeight - 1) * (std::abs(s[k] - t[k]) + std::abs(s[k + 1] - t[k + 1]));
  }

 private:
  static void list(const mapping::SegmentFeatures& f, double (&value)[kAll]) {
    const double features[kFeatures] = {f.linearity,  f.planarity,    f.scattering,      f.omnivariance,
                                        f.anisotropy, f.eigenentropy, f.curvature_change};
    for (std::size_t i = 0; i < kFeatures; ++i) value[i] = features[i];
    constexpr double least = mapping::kLeastSpread_m * mapping::kLeastSpread_m;
    for (std::size_t i = 0; i < 3; ++i) value[kFeatures + i] = std::log(f.spread_m2[i] + least);
  }
  double of_features(const SpokenSegment& a, const SpokenSegment& b, std::size_t count) const {
    double of_a[kAll], of_b[kAll], square = 0.0;
    list(a.features, of_a);
    list(b.features, of_b);
    for (std::size_t i = 0; i < count; ++i) {
      const double apart = (of_a[i] - of_b[i]) * per_spread_[i];
      square += apart * apart;
    }
    return std::sqrt(square);
  }

  double per_spread_[kAll]{};
};

}  // namespace sortie::bench
