// SPDX-License-Identifier: BSD-3-Clause
// What looks on long drives come to: recall and precision, by distance and by the size of sets.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tests/bench/recognition/loop_drive.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

inline constexpr double kRevisit_m = 5.0;
inline constexpr double kLeast_m = 10.0;  ///< of way, that a revisit has
inline constexpr int kLoopBins = 25;      ///< of a metre
inline constexpr std::uint32_t kLoopSets[] = {6, 8, 10, 12, 15, 20, 25, 30};

using Told = std::optional<PoseError>;
/// What is believed: segments alone, or a scan that fits there, too.
using Believed = Told LoopLook::*;

/// Looks, and what was told in them.
struct Asked {
  int looks{}, right{}, wrong{};
  void add(const Told& told) {
    ++looks;
    right += is_right(told) ? 1 : 0;
    wrong += is_wrong(told) ? 1 : 0;
  }
  static Json share(int part, int of) {
    return of == 0 ? Json("-") : Json(std::round(1000.0 * part / of) / 10);
  }
  Json recall() const { return share(right, looks); }
  Json precision() const { return share(right, right + wrong); }
};

/// Stretches of way on which the robot is where it was before.
struct Revisits {
  int all{}, recognised{}, within_3m{};
  Rounds way_m;  ///< from the beginning until the first right look
  void add(const std::vector<LoopLook>& looks, Believed believed) {
    for (std::size_t i = 0; i < looks.size();) {
      std::size_t end = i;
      double first_m = -1.0;
      for (; end < looks.size() && looks[end].nearest_m < kRevisit_m; ++end) {
        if (is_right(looks[end].*believed) && first_m < 0.0) first_m = looks[end].way_m - looks[i].way_m;
      }
      if (end > i && looks[end - 1].way_m - looks[i].way_m >= kLeast_m) {
        ++all;
        recognised += first_m >= 0.0 ? 1 : 0;
        within_3m += first_m >= 0.0 && first_m <= 3.0 ? 1 : 0;
        if (first_m >= 0.0) way_m.add(first_m);
      }
      i = std::max(end, i + 1);
    }
  }
};

/// What one kind of belief came to.
struct LoopTally {
  Believed believed;
  double way_m{};
  Revisits revisits;
  Asked all, on_revisit;
  Asked bins[kLoopBins + 1];  ///< by the distance to what was left, the last one: farther
  /// Right ones on revisits and wrong ones anywhere, of so many segments.
  Asked sets[std::size(kLoopSets)];
  Rounds off_m, off_deg;

  explicit LoopTally(Believed what) : believed(what) {}
  void add(const LoopDrive& drive, double driven_m) {
    way_m += driven_m;
    revisits.add(drive.looks, believed);
    for (const LoopLook& look : drive.looks) {
      const Told& told = look.*believed;
      const bool is_revisit = look.nearest_m < kRevisit_m;
      all.add(told);
      bins[look.nearest_m < kLoopBins ? static_cast<int>(look.nearest_m) : kLoopBins].add(told);
      if (is_revisit) on_revisit.add(told);
      for (std::size_t s = 0; s < std::size(kLoopSets); ++s) {
        const Told of_set = look.agree >= kLoopSets[s] ? told : std::nullopt;
        if (is_revisit || is_wrong(of_set)) sets[s].add(of_set);
      }
      if (!is_right(told)) continue;
      off_m.add(told->move_m);
      off_deg.add(told->turn_deg);
    }
  }
  double per_km(int count) const { return std::round(1e4 * count / way_m) / 10; }
};

/// Both beliefs of one drive, or of all.
struct LoopTallies {
  LoopTally by[2]{LoopTally(&LoopLook::found), LoopTally(&LoopLook::placed)};
  void add(const LoopDrive& drive, double driven_m) {
    for (LoopTally& tally : by) tally.add(drive, driven_m);
  }
};

}  // namespace sortie::bench
