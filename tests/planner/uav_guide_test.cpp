// SPDX-License-Identifier: BSD-3-Clause
// Ways over a map that changes: the same whatever is done in a job, restored in the middle of a search,
// looked at again when something comes up.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "planner/uav_guide.hpp"
#include "tests/planner/guide_archive.hpp"
#include "tests/planner/path_rig.hpp"

using namespace sortie;
using namespace sortie::planner;
using test::guide_bytes;
using test::restore_between_slices;

namespace {

FlightMapConfig guide_map() {
  FlightMapConfig config;
  config.nx = config.ny = 40;
  config.nz = 12;
  config.radii_m = {0.3, 0.3, 0.15};
  config.unknown_is_blocked = false;
  return config;
}

// Two walls with gaps on opposite sides; the second one's gap is shut after 5 s and another one stays.
const std::vector<KnownBox> kGuideWalls = {{{2.4, 0.0, 0.0}, {2.6, 6.0, 2.4}, 0},
                                           {{5.0, 2.0, 0.0}, {5.2, 6.0, 2.4}, 0},
                                           {{5.0, 0.0, 0.0}, {5.2, 2.0, 2.4}, 5 * rt::kNanosecondsPerSecond}};
const WayQuestion kGuideQuestion{1, {1.0, 1.0, 1.0}, {7.0, 1.0, 1.0}};

struct GuideRig {
  explicit GuideRig(const FlightMapConfig& config = guide_map())
      : map(config), path(map.map, 4096, 4096, 1024), guide(map.map, path.path, kGuideWalls) {}
  void work() {
    while (guide.works()) guide.step();
  }
  test::OwnedMap map;
  test::OwnedPath path;
  UavGuide guide;
};

}  // namespace

TEST_CASE("A way that is asked for keeps off what is known, and is looked at again when the map changes") {
  GuideRig rig;
  REQUIRE(rig.guide.status() == Status::ok);
  rig.guide.look(&kGuideQuestion, 0);
  rig.work();
  const UavWay first = rig.guide.way();
  REQUIRE(first.state == static_cast<std::uint32_t>(PathState::done));
  CHECK(first.whole == 1);
  CHECK(first.y_m[0] == 1.0);
  CHECK(first.length_m > 10.0);  // up past the first wall and down again to the second one's gap
  rig.guide.look(&kGuideQuestion, 4 * rt::kNanosecondsPerSecond);
  CHECK_FALSE(rig.guide.works());
  rig.guide.look(&kGuideQuestion, 5 * rt::kNanosecondsPerSecond);
  rig.work();
  CHECK(rig.guide.way().blocked == 1);
  WayQuestion next = kGuideQuestion;
  next.number = 2;
  rig.guide.look(&next, 6 * rt::kNanosecondsPerSecond);
  rig.work();
  const UavWay& second = rig.guide.way();
  CHECK(second.number == 2);
  CHECK(second.blocked == 0);
  REQUIRE(second.state == static_cast<std::uint32_t>(PathState::done));
  bool over_the_top = false;  // the only gap left is beyond both walls
  for (std::uint32_t i = 0; i < second.points; ++i) over_the_top = over_the_top || second.y_m[i] > 6.0;
  CHECK(over_the_top);
}

TEST_CASE("A search that is restored between any two slices ends as the one that was never interrupted") {
  const auto ask = [](GuideRig& rig) { rig.guide.look(&kGuideQuestion, 0); };
  CHECK(restore_between_slices<GuideRig>(ask, 7) > 1);  // there was something to cut
}

TEST_CASE("A refresh of the map that is restored in its middle ends as the one that was not") {
  const auto run = [](std::uint32_t cut) {
    GuideRig rig;
    rig.guide.look(&kGuideQuestion, 0);
    rig.work();
    rig.guide.look(&kGuideQuestion, 5 * rt::kNanosecondsPerSecond);
    for (std::uint32_t i = 0; i < cut && rig.guide.works(); ++i) rig.guide.step();
    const auto kept = guide_bytes(rig.guide);
    GuideRig restored;
    rt::Archive read = rt::Archive::reading(kept);
    restored.guide.archive(read);
    REQUIRE(read.status() == Status::ok);
    restored.work();
    return guide_bytes(restored.guide);
  };
  const auto expected = run(10'000);
  for (std::uint32_t cut = 0; cut < 20; ++cut) CHECK(run(cut) == expected);
}
