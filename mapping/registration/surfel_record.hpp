// SPDX-License-Identifier: BSD-3-Clause
// A surfel as it is kept, in a state or in a map file.
#pragma once

#include <cstdint>

#include "mapping/registration/surfel.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// A surfel with its cell. 136 bytes in canonical form.
struct SurfelRecord {
  std::uint64_t key{};  ///< SurfelCell::key()
  SurfelSums sums;
  Surfel surfel;
  SORTIE_FIELDS(key, sums, surfel)
};

/// Null where the record can be one of a layer with cells of an edge, m; else a static text that says what
/// cannot be. After null no sum overflows, and the Gaussian is finite and lies in its cell.
const char* fault_of(const SurfelRecord& record, double cell_m);

}  // namespace sortie::mapping
