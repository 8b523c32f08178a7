// SPDX-License-Identifier: BSD-3-Clause
// rt/convex over ten million random pairs, and depths over a hundred thousand shallow ones.
#include <cstdio>

#include "tests/rt/convex_checks.hpp"

namespace sortie::rt::convex::test {

constexpr std::uint64_t kSeed = 4711;

TEST_CASE("convex: no false free in ten million random pairs") {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  Draw draw(kSeed);
  Verdicts boxes;
  for (int i = 0; i < 5000000; ++i) check_boxes(draw, boxes);
  boxes.require();
  Verdicts tracks;
  for (int i = 0; i < 5000000; ++i) check_track_and_box(draw, tracks);
  tracks.require();
  CHECK(tracks.states[3] < 2000);  // near touches that end on the budget; they count as collisions
}

TEST_CASE("convex: the depth of a hundred thousand shallow contacts") {
  Draw draw(kSeed + 1);
  ShallowCount count;
  for (int i = 0; i < 100000; ++i) check_shallow(draw, count);
  std::printf("shallow contacts judged %ld, more than 1 mm wrong %ld, worst %.3f mm\n", count.judged,
              count.wrong, 1e3 * count.worst_m);
  CHECK(count.judged > 90000);
  CHECK(count.wrong * 10000 < count.judged);
}

}  // namespace sortie::rt::convex::test
