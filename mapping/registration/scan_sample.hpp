// SPDX-License-Identifier: BSD-3-Clause
// A scan's returns, thinned: as many as a match can use, spread over the surfaces instead of over the
// sensor's angles.
#pragma once

#include <cstdint>
#include <span>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"

namespace sortie::mapping {

/// What became of a scan's returns. in = kept + all others.
struct ScanSampleCounts {
  std::uint64_t in{};
  std::uint64_t kept{};
  std::uint64_t not_finite{};
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t thinned{};
  SORTIE_FIELDS(in, kept, not_finite, too_near, too_far, thinned)
};

/// A return of the sample, sensor frame, m.
struct SamplePoint {
  float x_m{};
  float y_m{};
  float z_m{};

  rt::Vector3 at() const {
    return {static_cast<double>(x_m), static_cast<double>(y_m), static_cast<double>(z_m)};
  }
};

/// Chooses returns. What it chooses, and in which order it gives it, depends on the returns alone and not on
/// their order. Memory: 16 bytes a slot. No heap.
class ScanSample {
 public:
  struct Slot {
    std::uint64_t rank{};  ///< of its return; the least one stays
    std::uint32_t index{};
    std::uint32_t scan{};  ///< that wrote it
  };

  /// `slots`: a power of two; four times the most returns wanted lose few of them to shared slots. `edge_m`:
  /// at most one return a cube of it.
  ScanSample(double edge_m, double min_range_m, double max_range_m, std::span<Slot> slots)
      : per_edge_(1.0 / edge_m),
        min2_(min_range_m * min_range_m),
        max2_(max_range_m * max_range_m),
        slots_(slots) {}

  /// At most out.size() returns of the scan; how many. One hash a return.
  std::size_t choose(std::span<const rt::ScanPoint> scan, std::span<SamplePoint> out,
                     ScanSampleCounts& counts);

 private:
  double per_edge_;
  double min2_;
  double max2_;
  std::span<Slot> slots_;
  std::uint32_t scan_{};
};

}  // namespace sortie::mapping
