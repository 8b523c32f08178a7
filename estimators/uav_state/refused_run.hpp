// SPDX-License-Identifier: BSD-3-Clause
// What a gate has refused of late: whether it agrees with itself, and for how long nothing else came.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::estimators {

/// Refused measurements of one kind (places, headings) since one of them was last believed. A gate that goes
/// on refusing what agrees with itself is wrong itself: its owner looks at `agreeing` and gives in. One that
/// refuses what does not agree knows nothing any more: its owner looks at `doubted_s()` and says so in its
/// verdict. Every gate of an estimator has one of the two ways out. 40 bytes.
struct RefusedRun {
  std::uint32_t agreeing{};    ///< so many in a row agree with each other; the newest is one of them
  bool doubted{};              ///< one was refused since one was believed
  rt::Nanoseconds from_ns{};   ///< stamp of the first of those that agree
  rt::Nanoseconds last_ns{};   ///< of the newest that was refused
  rt::Nanoseconds doubt_ns{};  ///< of the first that was refused since one was believed
  SORTIE_FIELDS(agreeing, doubted, from_ns, last_ns, doubt_ns)

  /// One was believed.
  void clear() { *this = {}; }

  /// A copy of the newest, or one that is older, says nothing new.
  bool is_news(rt::Nanoseconds stamp_ns) const { return !doubted || stamp_ns > last_ns; }

  /// One more was refused; is_news(stamp_ns). `near`: it is like the one before. True: it goes on from that.
  bool add(rt::Nanoseconds stamp_ns, bool near) {
    const bool follows = agreeing > 0 && near;
    if (!doubted) doubt_ns = stamp_ns;
    if (!follows) from_ns = stamp_ns;
    doubted = true;
    last_ns = stamp_ns;
    agreeing = follows ? agreeing + 1 : 1;
    return follows;
  }

  /// How long those that agree have gone on.
  double agreed_s() const { return agreeing > 0 ? rt::to_seconds(last_ns - from_ns) : 0.0; }
  /// How long nothing but refused ones came: from the first to the newest.
  double doubted_s() const { return doubted ? rt::to_seconds(last_ns - doubt_ns) : 0.0; }
};

}  // namespace sortie::estimators
