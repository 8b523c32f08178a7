// SPDX-License-Identifier: BSD-3-Clause
// Which label the delays of a run of the rig got, beside what the rig had done to it.
#pragma once

#include "tests/rt/cause_rig.hpp"

namespace sortie::rt::posix::test {

/// Which label an injected delay got.
struct ConfusionRow {
  std::uint32_t injected{};  ///< injections
  std::uint32_t outliers{};  ///< delays that lie in one of them
  std::uint32_t label[kDelayCauses]{};
  Nanoseconds total_ns{};
  Nanoseconds unknown_ns{};
  std::uint32_t other_outliers{};  ///< delays that lie in none: the machine's own
  std::uint32_t other_label[kDelayCauses]{};
  Nanoseconds other_total_ns{};
  Nanoseconds other_unknown_ns{};
};

/// A delay belongs to an injection if that fell into it.
inline ConfusionRow judge(const RigResult& result) {
  ConfusionRow row;
  row.injected = result.injected_count.load();
  for (std::uint32_t i = 0; i < result.outlier_count; ++i) {
    const DelayOutlier& outlier = result.outliers[i];
    bool inside = false;
    for (std::uint32_t k = 0; k < row.injected; ++k) {
      const Injected& injected = result.injected[k];
      // Behind the end of an injection its consequences may still last for a job.
      inside = inside || (outlier.at_ns > injected.begin_ns &&
                          outlier.at_ns - outlier.late_ns < injected.end_ns + 100'000);
    }
    const auto cause = static_cast<int>(outlier.split.main_cause());
    const Nanoseconds unknown = outlier.split[DelayCause::unknown];
    if (inside) {
      ++row.outliers;
      ++row.label[cause];
      row.total_ns += outlier.late_ns;
      row.unknown_ns += unknown;
    } else {
      ++row.other_outliers;
      ++row.other_label[cause];
      row.other_total_ns += outlier.late_ns;
      row.other_unknown_ns += unknown;
    }
  }
  return row;
}

}  // namespace sortie::rt::posix::test
