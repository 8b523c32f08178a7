// SPDX-License-Identifier: BSD-3-Clause
// Work that is paid in units, a budget at a time.
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::mapping {

/// What budgets left that were too small for the next step.
class UnitCredit {
 public:
  void clear() { kept_ = 0; }

  /// Takes a step's cost from what was kept and then from `units`. False: both together are too little; all
  /// of `units` is kept for the next time.
  bool pay(std::uint64_t cost, std::uint64_t& units) {
    if (units + kept_ < cost) {
      kept_ += units;
      units = 0;
      return false;
    }
    const std::uint64_t from_kept = std::min(kept_, cost);
    kept_ -= from_kept;
    units -= cost - from_kept;
    return true;
  }

  SORTIE_FIELDS(kept_)

 private:
  std::uint64_t kept_{};
};

}  // namespace sortie::mapping
