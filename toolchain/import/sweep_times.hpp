// SPDX-License-Identifier: BSD-3-Clause
// Which of the times that a sweep gives its points can be believed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rt/samples.hpp"
#include "toolchain/import/importer.hpp"

namespace sortie::toolchain {

/// A point of a sweep as its file has it.
struct SweepPoint {
  float x_m{};  ///< in the lidar's frame
  float y_m{};
  float z_m{};
  std::uint32_t since_first_ns{};
};

/// A sweep as a scan has it: oldest point first, ages up to its newest.
struct TimedScan {
  rt::Nanoseconds newest_ns{};  ///< since the first point of the sweep
  std::vector<rt::ScanPoint> points;
  ReturnCounts returns;
  std::string fault;  ///< empty, or why the sweep cannot be used at all
};

/// Sorts the points of a sweep by time. `points` holds `rows` rows of `columns`, in each the points in the
/// order in which they were taken. The turn takes `columns` times the median step between two neighbours in a
/// row. A point after its end, before the first point, or out of order in its row is left out and counted, as
/// is one that is no return (NaN) or infinite. Of two neighbours out of order the one that the next point
/// contradicts is left out. Unusable: no point, a turn of no length or one longer than 655.35 ms, which a
/// scan cannot hold. Cost: n log n.
TimedScan order_sweep(const std::vector<SweepPoint>& points, std::uint32_t rows, std::uint32_t columns);

}  // namespace sortie::toolchain
