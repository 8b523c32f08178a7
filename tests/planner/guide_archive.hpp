// SPDX-License-Identifier: BSD-3-Clause
// A guide's state as bytes, and guides that are interrupted between any two slices.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "planner/uav_guide.hpp"
#include "rt/archive.hpp"

namespace sortie::planner::test {

inline std::vector<std::uint8_t> guide_bytes(UavGuide& guide) {
  rt::Archive measure = rt::Archive::measuring();
  guide.archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  guide.archive(write);
  REQUIRE(write.status() == Status::ok);
  return bytes;
}

/// Works a Rig that `begin` has asked something to its end, and others that are kept after 0, `stride`,
/// 2 * stride ... slices and restored into a new one: all end alike. Returns how many were kept.
template <class Rig, class Begin>
std::uint32_t restore_between_slices(Begin begin, std::uint32_t stride) {
  Rig whole;
  begin(whole);
  whole.work();
  const auto expected = guide_bytes(whole.guide);
  std::uint32_t kept = 0;
  for (std::uint32_t cut = 0;; cut += stride) {
    Rig begun;
    begin(begun);
    for (std::uint32_t slices = 0; slices < cut && begun.guide.works(); ++slices) begun.guide.step();
    if (!begun.guide.works()) return kept;
    const auto bytes = guide_bytes(begun.guide);
    Rig restored;
    rt::Archive read = rt::Archive::reading(bytes);
    restored.guide.archive(read);
    REQUIRE(read.status() == Status::ok);
    restored.work();
    INFO("cut after " << cut);
    REQUIRE(guide_bytes(restored.guide) == expected);
    ++kept;
  }
}

}  // namespace sortie::planner::test
