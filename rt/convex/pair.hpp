// SPDX-License-Identifier: BSD-3-Clause
// The judgement of one pair that query() and manifold() share.
#pragma once

#include <cstdint>

#include "rt/convex/axes.hpp"
#include "rt/convex/overlay.hpp"
#include "rt/convex/query.hpp"

namespace sortie::rt::convex {

/// Overlaps and gaps up to this are "touching": above rounding, below what any contact can tell.
constexpr double kTouching_m = 1e-9;

/// State, best direction, and the points (world, less b's origin) where the bodies face each other along it.
struct PairJudgement {
  State state{State::unknown};
  Axis axis{};
  Overlay points{};  ///< empty when the gap is wider than the margin; else at least one
  std::uint32_t support_calls{};
};

/// Judges the pair. `margin_m`: gaps up to this get points; `face_preference_m`: see ManifoldOptions. The
/// bodies must be valid. Stack: about 6 kB.
PairJudgement judge_pair(const Convex& a, const Convex& b, double margin_m, double face_preference_m,
                         const Budget& budget);

}  // namespace sortie::rt::convex
