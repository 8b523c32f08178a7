// SPDX-License-Identifier: BSD-3-Clause
// The best few of many shifts, well apart.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mapping/recognition/image_view.hpp"

namespace sortie::mapping {

/// A place on a kept image, and how good it is.
struct ImagePeak {
  static constexpr std::uint32_t kMost = 24;
  std::uint32_t image{};
  ImagePlace place;
  std::int32_t score{};
};

/// Keeps the best shifts of one turn, each more than kApart cells from the others along x or y. One that is
/// offered takes the place of those it is near to and better than; of as good ones the first one stays.
template <std::uint32_t kMost>
class ImagePeaks {
 public:
  static constexpr std::int32_t kApart = 4;

  void clear() { count_ = 0; }
  void offer(const ImagePeak& peak) {
    if (count_ == kMost && peak.score <= peaks_[count_ - 1].score) return;
    const auto is_near = [&peak](const ImagePeak& other) {
      return std::abs(other.place.x - peak.place.x) <= kApart &&
             std::abs(other.place.y - peak.place.y) <= kApart;
    };
    for (std::uint32_t i = 0; i < count_ && peaks_[i].score >= peak.score; ++i) {
      if (is_near(peaks_[i])) return;
    }
    const auto worse = std::remove_if(peaks_, peaks_ + count_, [&](const ImagePeak& other) {
      return other.score < peak.score && is_near(other);
    });
    count_ = static_cast<std::uint32_t>(worse - peaks_);
    if (count_ == kMost) --count_;
    std::uint32_t at = count_++;
    for (; at > 0 && peaks_[at - 1].score < peak.score; --at) peaks_[at] = peaks_[at - 1];
    peaks_[at] = peak;
  }
  std::span<const ImagePeak> peaks() const { return {peaks_, count_}; }

 private:
  ImagePeak peaks_[kMost];
  std::uint32_t count_{};
};

}  // namespace sortie::mapping
