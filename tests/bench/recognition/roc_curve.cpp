// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/roc_curve.hpp"

#include <algorithm>

namespace sortie::bench {

RocCurve::RocCurve(std::vector<JudgedPair> pairs) : pairs_(std::move(pairs)) {
  std::sort(pairs_.begin(), pairs_.end(),
            [](const JudgedPair& a, const JudgedPair& b) { return a.distance < b.distance; });
  double same = 0.0, others = 0.0;
  std::size_t groups = 0;
  for (const JudgedPair& pair : pairs_) {
    (pair.same ? same : others) += 1.0;
    groups = std::max(groups, pair.group + 1);
  }
  if (same == 0.0 || others == 0.0) return;
  double accepted_same = 0.0, accepted_others = 0.0;
  false_share_.push_back(0.0);
  true_share_.push_back(0.0);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    (pairs_[i].same ? accepted_same : accepted_others) += 1.0;
    if (i + 1 < pairs_.size() && pairs_[i + 1].distance == pairs_[i].distance) continue;
    false_share_.push_back(accepted_others / others);
    true_share_.push_back(accepted_same / same);
  }
  area_ = area(std::vector<double>(groups, 1.0));
}

double RocCurve::area(const std::vector<double>& times) const {
  double same = 0.0, others = 0.0, won = 0.0;
  for (std::size_t i = 0; i < pairs_.size();) {
    double tied_same = 0.0, tied_others = 0.0;
    for (const double distance = pairs_[i].distance; i < pairs_.size() && pairs_[i].distance == distance; ++i)
      (pairs_[i].same ? tied_same : tied_others) += times[pairs_[i].group];
    won += tied_others * (same + 0.5 * tied_same);
    same += tied_same;
    others += tied_others;
  }
  return same > 0.0 && others > 0.0 ? won / (same * others) : 0.5;
}

double RocCurve::found_at(double share) const {
  for (std::size_t i = 1; i < false_share_.size(); ++i) {
    if (false_share_[i] < share) continue;
    const double wide = false_share_[i] - false_share_[i - 1];
    const double part = wide > 0.0 ? (share - false_share_[i - 1]) / wide : 1.0;
    return true_share_[i - 1] + part * (true_share_[i] - true_share_[i - 1]);
  }
  return 0.0;
}

}  // namespace sortie::bench
