// SPDX-License-Identifier: BSD-3-Clause
// Insertion by itself: beside a sorted vector on a recorded drive, and in maps of several sizes.
#pragma once

#include <vector>

#include "tests/bench/report/figures.hpp"
#include "tests/mapping/recorded_scans.hpp"

namespace sortie::bench {

/// CPU time of this thread, ms.
double mapping_cpu_ms();

/// Time a point on the drive with every `stride`-th point, ours and the sorted vector's on the same points.
void insertion_beside_sorted(const std::vector<tests::RecordedScan>& scans, std::uint32_t stride,
                             Report& report);

/// Time a point for the same scan in maps of 10,000 to 150,000 voxels.
void insertion_by_size(Report& report);

}  // namespace sortie::bench
