// SPDX-License-Identifier: BSD-3-Clause
// How full processors are that several groups share. One rule for what is measured and for what is declared:
// a group is one thread, so it can use one processor at most; all groups together can use all of them.
#pragma once

namespace sortie::rt {

/// Sums up the groups that share some processors. Loads are shares of one processor.
class SharedLoad {
 public:
  /// A group that may run on any of the processors.
  constexpr void add(double load) {
    sum_ += load;
    largest_ = load > largest_ ? load : largest_;
  }
  /// A group with one of the processors for its own place: it takes room, but its load is judged there.
  constexpr void add_other(double load) { sum_ += load; }

  /// 1: full. Of `processors` (> 0; a quota may allow a part of one): the share that is used, or how full the
  /// processor of the busiest group is if that is more. NaN if a load was.
  constexpr double share(double processors) const {
    const double together = sum_ / processors;
    const double own = processors < 1 ? largest_ / processors : largest_;
    return own > together ? own : together;
  }

 private:
  double sum_{};
  double largest_{};
};

}  // namespace sortie::rt
