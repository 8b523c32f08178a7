// SPDX-License-Identifier: BSD-3-Clause
// How well a distance tells what is the same from what is not: the receiver operating characteristic.
#pragma once

#include <cstddef>
#include <vector>

namespace sortie::bench {

/// A pair whose truth is known. `group`: pairs of one group are drawn together.
struct JudgedPair {
  double distance{};
  bool same{};
  std::size_t group{};
};

/// Share of the same pairs that are accepted, against the share of the others, for all thresholds.
class RocCurve {
 public:
  /// Without pairs of both kinds the area is 0.5 and the curve is empty.
  explicit RocCurve(std::vector<JudgedPair> pairs);

  /// Area under the curve: how often a same pair has the smaller distance of two; a tie is half a time.
  double area() const { return area_; }
  /// The area when each group counts as often as `times` says.
  double area(const std::vector<double>& times) const;
  /// Share of the same pairs that is found where so large a share of the others is accepted.
  double found_at(double false_share) const;
  /// The curve's corners, from (0, 0) to (1, 1).
  const std::vector<double>& false_share() const { return false_share_; }
  const std::vector<double>& true_share() const { return true_share_; }

 private:
  std::vector<JudgedPair> pairs_;  ///< nearest first
  std::vector<double> false_share_, true_share_;
  double area_{0.5};
};

}  // namespace sortie::bench
