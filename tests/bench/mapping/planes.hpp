// SPDX-License-Identifier: BSD-3-Clause
// Planes: growing them over cells, and finding one set in another.
#pragma once

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Registration of 29 x 24 and 149 x 29 planes of random halls, a third to most of them seen by one side
/// alone; growing of the cells of 290,000 points from scratch and of a twentieth of them again.
void plane_times(Report& report);

}  // namespace sortie::bench
