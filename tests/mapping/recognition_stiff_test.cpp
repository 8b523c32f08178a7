// SPDX-License-Identifier: BSD-3-Clause
// Stiff and extreme cases of recognition: looks that say nothing, frames that are tilted, places that are
// nearly or exactly where they were, numbers that wrap.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using mapping::PlaceCm;
using mapping::SetVerdict;

struct Point {
  double x, y, z;
};

/// A turn about the upright and a move, cm.
struct Pose {
  double yaw{}, x{}, y{}, z{};
  Point operator()(const Point& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {c * p.x - s * p.y + x, s * p.x + c * p.y + y, p.z + z};
  }
};

PlaceCm rounded(const Point& p) {
  const auto whole = [](double v) { return static_cast<std::int32_t>(std::floor(v + 0.5)); };
  return {whole(p.x), whole(p.y), whole(p.z)};
}

/// Things at least 1.5 m from each other.
std::vector<Point> things(int count, testing::TargetDraws& draws) {
  std::vector<Point> all;
  while (static_cast<int>(all.size()) < count) {
    const Point p{draws.draws.uniform(-1'200, 1'200), draws.draws.uniform(-1'200, 1'200),
                  draws.draws.uniform(-50, 300)};
    const auto is_near = [&](const Point& o) { return std::hypot(p.x - o.x, p.y - o.y) < 150; };
    if (std::none_of(all.begin(), all.end(), is_near)) all.push_back(p);
  }
  return all;
}

mapping::SegmentDescriptor alike() {
  mapping::SegmentDescriptor one{};
  for (auto& step : one.step) step = 100;
  return one;
}

/// Looks of which no two are alike.
mapping::SegmentDescriptor look_of(std::uint32_t number) {
  mapping::SegmentDescriptor one = alike();
  one.step[7] = static_cast<std::uint8_t>(8 * (number % 32));
  one.step[9] = static_cast<std::uint8_t>(40 * (number / 32));
  return one;
}

/// A store, and a recogniser that searches it.
struct Rig {
  std::vector<std::byte> memory = std::vector<std::byte>(4 << 20);
  rt::Arena arena{memory};
  mapping::TargetStore store{{256, 4, 0, 0, 500}, arena};
  mapping::Recogniser part;
  std::vector<mapping::SpeakingSegment> segments;
  std::uint32_t next_id{};

  explicit Rig(const mapping::RecogniserConfig& config = {}) : part(config, arena) {
    REQUIRE(arena.refused() == 0);
    REQUIRE(store.set_key_frame(0, {}) == Status::ok);
  }
  void keep(const Point& at, const mapping::SegmentDescriptor& look) {
    mapping::TargetSighting seen;
    seen.id = next_id++;
    seen.robot = 1;
    seen.offset = rounded(at);
    seen.descriptor = look;
    REQUIRE(store.put(seen).status == Status::ok);
  }
  void see(const Point& at, const mapping::SegmentDescriptor& look) {
    segments.push_back({static_cast<std::uint32_t>(segments.size()), 1, rounded(at), look});
  }
  SetVerdict ask() {
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(store.run(units));
    part.begin(segments, {});
    REQUIRE(part.run(store, units));
    return part.verdict();
  }
  /// How far the place found is from the right one, m, at the local map's middle and 10 m from it.
  double off_m(const Pose& truth) const {
    const mapping::LevelPlace& found = part.found()[0].fit.place;
    double worst = 0;
    for (const Point& p : {Point{0, 0, 0}, Point{1'000, 0, 0}}) {
      const Point there = truth(p);
      worst = std::max(
          worst, std::hypot(found.cosine * 0.01 * p.x - found.sine * 0.01 * p.y + found.x_m - 0.01 * there.x,
                            found.sine * 0.01 * p.x + found.cosine * 0.01 * p.y + found.y_m - 0.01 * there.y,
                            found.z_m - 0.01 * there.z));
    }
    return worst;
  }
};

Pose any_pose(testing::TargetDraws& draws) {
  return {draws.draws.uniform(-3, 3), draws.draws.uniform(-9'000, 9'000), draws.draws.uniform(-9'000, 9'000),
          draws.draws.uniform(-200, 900)};
}
}  // namespace

TEST_CASE("Where all segments look alike their places alone tell a place, and never a wrong one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int run = 0; run < 100; ++run) {
    INFO("run " << run);
    Rig rig;
    const Pose truth = any_pose(draws);
    for (const Point& p : things(16, draws)) {
      rig.see(p, alike());
      rig.keep(truth(p), alike());
    }
    REQUIRE(rig.ask() == SetVerdict::found);
    CHECK(rig.off_m(truth) < 0.03);
  }
}

TEST_CASE("A grid of columns that look alike is ambiguous, wherever in it the robot stands") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int run = 0; run < 40; ++run) {
    INFO("run " << run);
    Rig rig;
    const Pose truth = any_pose(draws);
    const int at_x = draws.whole(0, 3), at_y = draws.whole(0, 3);
    for (int x = 0; x < 8; ++x) {
      for (int y = 0; y < 8; ++y) {
        const Point column{400.0 * (x - at_x), 500.0 * (y - at_y), 100};
        rig.keep(truth(column), alike());
        if (x >= at_x && x < at_x + 4 && y >= at_y && y < at_y + 4) rig.see(column, alike());
      }
    }
    const SetVerdict verdict = rig.ask();
    CHECK((verdict == SetVerdict::ambiguous || verdict == SetVerdict::undecided));
  }
}

TEST_CASE("A robot that stands where the map was made is told so, and one that nearly does how far off") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (const double cm : {0.0, 1.0, 20.0}) {
    Rig rig;
    const Pose truth{0.0005 * cm, cm, -cm, 0};
    const std::vector<Point> all = things(20, draws);
    for (std::uint32_t i = 0; i < 20; ++i) {
      rig.see(all[i], look_of(i));
      rig.keep(truth(all[i]), look_of(i));
    }
    REQUIRE(rig.ask() == SetVerdict::found);
    CHECK(rig.part.found()[0].count == 20);
    CHECK(rig.off_m(truth) < 0.02);
    if (cm == 0) CHECK(rig.off_m(Pose{}) == 0);
  }
}

TEST_CASE("A frame that leans is recognised where its tilt is allowed for, and nowhere wrongly") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  for (int run = 0; run < 40; ++run) {
    INFO("run " << run);
    const double tilt_deg = run % 2 == 0 ? 2.0 : 5.0;
    mapping::RecogniserConfig allowed;
    allowed.set.tilt_deg = tilt_deg;
    Rig strict, open(allowed);
    const Pose truth = any_pose(draws);
    const double roll = tilt_deg * M_PI / 180, c = std::cos(roll), s = std::sin(roll);
    const std::vector<Point> all = things(24, draws);
    for (std::uint32_t i = 0; i < 24; ++i) {
      const Point& p = all[i];
      for (Rig* rig : {&strict, &open}) {
        rig->see({p.x, c * p.y - s * p.z, s * p.y + c * p.z}, look_of(i));
        rig->keep(truth(p), look_of(i));
      }
    }
    for (Rig* rig : {&strict, &open}) {
      if (rig->ask() == SetVerdict::found) CHECK(rig->off_m(truth) < 1);
    }
    // At 5 degrees things 10 m away are off by 0.9 m: no level pose lays them all within eps.
    if (tilt_deg < 3) CHECK(open.part.verdict() == SetVerdict::found);
  }
}

TEST_CASE("Ids and versions that wrap are names like others") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  Rig low, high;
  const Pose truth = any_pose(draws);
  const std::vector<Point> all = things(20, draws);
  for (std::uint32_t i = 0; i < 20; ++i) {
    for (Rig* rig : {&low, &high}) {
      rig->see(all[i], look_of(i));
      rig->keep(truth(all[i]), look_of(i));
    }
    high.segments[i].id = 0xffffffffu - 10 + i;
    high.segments[i].version = 0xffffffffu - i;
  }
  REQUIRE(low.ask() == SetVerdict::found);
  REQUIRE(high.ask() == SetVerdict::found);
  CHECK(high.part.found()[0].count == 20);
  CHECK(high.off_m(truth) < 0.02);
}

TEST_CASE("Segments in one place, on one line, or one too many for the table give no wrong place") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  const Pose truth = any_pose(draws);
  Rig one_place;
  for (std::uint32_t i = 0; i < 20; ++i) {
    one_place.see({100, 100, 50}, look_of(i));
    one_place.keep(truth({100, 100, 50}), look_of(i));
  }
  // Every set agrees: the largest may not be known in time.
  const SetVerdict in_one_place = one_place.ask();
  CHECK((in_one_place == SetVerdict::narrow || in_one_place == SetVerdict::undecided));
  mapping::RecogniserConfig of_three;
  of_three.set.least = 3;
  Rig line(of_three);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const Point p{400.0 * i, 300.0 * i, 80};
    line.see(p, look_of(i));
    line.keep(truth(p), look_of(i));
  }
  CHECK(line.ask() == SetVerdict::narrow);
  mapping::RecogniserConfig small;
  small.segments = 16;
  Rig full(small);
  const std::vector<Point> all = things(17, draws);
  for (std::uint32_t i = 0; i < 17; ++i) {
    full.see(all[i], look_of(i));
    full.keep(truth(all[i]), look_of(i));
  }
  REQUIRE(full.ask() == SetVerdict::found);
  CHECK(full.part.found()[0].count == 16);
  CHECK(full.off_m(truth) < 0.02);
}

TEST_CASE("A search that finds nothing has a reason, and each reason its counter") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  Rig rig;
  const std::vector<Point> all = things(20, draws), elsewhere = things(20, draws);
  for (std::uint32_t i = 0; i < 20; ++i) {
    rig.see(all[i], look_of(i));
    rig.keep(elsewhere[i], look_of(i));
  }
  // Every segment has a target that looks like it, and none stands as they do.
  const SetVerdict verdict = rig.ask();
  CHECK((verdict == SetVerdict::inconsistent || verdict == SetVerdict::bent));
  const mapping::RecogniserCounts& counts = rig.part.counts();
  CHECK(counts.begun == 1);
  CHECK(counts.found == 0);
  CHECK(counts.inconsistent + counts.bent == 1);
}
