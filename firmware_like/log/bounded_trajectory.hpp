// SPDX-License-Identifier: BSD-3-Clause
// A trajectory that cannot outgrow its memory, however long a run lasts.
#pragma once

#include <cstddef>
#include <vector>

#include "firmware_like/log/timed_pose.hpp"

namespace sortie::firmware {

/// Keeps values with a `stamp_ns` at a spacing that doubles whenever `most` of them are held: then every
/// second one is dropped. The first one stays. Memory: at most `most` values.
template <class T>
class BoundedSeries {
 public:
  /// `spacing_ns`: least time between two kept values at the beginning.
  explicit BoundedSeries(std::int64_t spacing_ns, std::size_t most = std::size_t{1} << 20)
      : spacing_ns_(spacing_ns), most_(most) {}

  /// Takes a value, unless it comes too soon after the last kept one.
  void add(const T& value) {
    if (!values_.empty() && value.stamp_ns < values_.back().stamp_ns + spacing_ns_) return;
    if (values_.size() >= most_) thin();
    values_.push_back(value);
  }

  /// What was kept, oldest first.
  std::vector<T> take() { return std::move(values_); }
  std::size_t size() const { return values_.size(); }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values_.size(); i += 2) values_[kept++] = values_[i];
    values_.resize(kept);
    spacing_ns_ *= 2;
  }

  std::vector<T> values_;
  std::int64_t spacing_ns_;
  std::size_t most_;
};

/// Poses, about 80 bytes each.
using BoundedTrajectory = BoundedSeries<TimedPose>;

}  // namespace sortie::firmware
