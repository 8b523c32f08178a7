// SPDX-License-Identifier: BSD-3-Clause
// Where a lidar driver, real or simulated, puts its scans: points are written once, into the receiver's own
// buffer.
#pragma once

#include <cstdint>

#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Receiver of scans that owns the buffers (usually a pool). A source asks for room, writes the points into
/// it, and hands the scan over with its header; nothing is copied. One thread may use a sink at a time, and
/// one reservation may be open at a time. No call blocks, allocates or throws.
class ScanSink {
 public:
  virtual ~ScanSink() = default;

  /// Room for `capacity` points, at least until commit() or cancel(). Null means refused: no buffer is free,
  /// `capacity` is larger than a buffer, or a reservation is still open. The source then drops that scan and
  /// counts it; the sink counts it, too.
  [[nodiscard]] virtual rt::ScanPoint* reserve(std::uint32_t capacity) noexcept = 0;

  /// Hands over the open reservation, of which the first `header.points` (<= capacity) are filled. Points are
  /// in the sensor frame at the time of each point: header.stamp_ns - 10 us * age_10us. Status: ok; full
  /// (taken back: no room in the queue behind); malformed (no open reservation, or too many points). After
  /// any of them no reservation is open.
  [[nodiscard]] virtual Status commit(const rt::ScanHeader& header) noexcept = 0;

  /// Gives the open reservation back unused. Without one it does nothing.
  virtual void cancel() noexcept = 0;
};

}  // namespace sortie::drivers
