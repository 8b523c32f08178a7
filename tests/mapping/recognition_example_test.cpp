// SPDX-License-Identifier: BSD-3-Clause
// The program of docs/recognition.md, as it stands there, on a yard with eleven things: kept by one robot,
// recognised by another one that began elsewhere.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "mapping/recognition/segment_describer.hpp"
#include "mapping/recognition/segment_watch.hpp"
#include "mapping/recognition/target_store.hpp"
#include "tests/mapping/random_worlds.hpp"
#include "tests/mapping/segment_bodies.hpp"

namespace {
using namespace sortie;

// --- as on the page, from here on

/// A round: which segments of the map may speak, and what they look like.
template <class Segmenter>
bool describe_segments(const mapping::RollingGrid& grid, const Segmenter& segmenter, rt::Nanoseconds now_ns,
                       mapping::SegmentDescriber& describer, mapping::SegmentWatch& watch) {
  const mapping::Labelling& labelling = segmenter.labelling();
  if (describer.begin(grid, labelling) != Status::ok) return false;
  while (describer.stage() == mapping::DescribeStage::summing)
    describer.run(grid, segmenter.graph(), labelling, 10'000);  // a slice: the first visit
  if (watch.begin(now_ns) != Status::ok) return false;
  watch.note(labelling.events());  // and first those of labellings since the last round, if there were any
  for (std::uint16_t slot = 0; slot < describer.slots(); ++slot) {
    const auto voxels = static_cast<std::uint32_t>(describer.moments(slot).count);
    if (voxels > 0) watch.see({labelling.id(slot), voxels, describer.place(slot), describer.is_inside(slot)});
  }
  watch.end();
  std::uint16_t chosen[64];
  std::uint32_t count = 0;
  for (std::uint16_t slot = 0; slot < describer.slots() && count < 64; ++slot) {
    const mapping::WatchedSegment* segment = watch.find(labelling.id(slot));
    if (segment != nullptr && segment->wanted && describer.moments(slot).count > 0) chosen[count++] = slot;
  }
  if (describer.choose({chosen, count}) != Status::ok) return false;
  while (describer.stage() == mapping::DescribeStage::framing ||
         describer.stage() == mapping::DescribeStage::counting)
    describer.run(grid, segmenter.graph(), labelling, 10'000);  // the second visit, of these alone
  for (const mapping::DescribedSegment& one : describer.described())
    if (one.sound) watch.describe(one.id, one.descriptor);
  return true;
}

/// Keeps what speaks, as seen from a key frame.
void keep_segments(const mapping::SegmentWatch& watch, std::uint16_t key_frame, std::uint8_t robot,
                   std::uint32_t stamp_ms, mapping::TargetStore& store) {
  const mapping::KeyFramePose& frame = store.key_frames().latest(key_frame);
  for (const mapping::WatchedSegment& one : watch.segments()) {
    if (!one.speaks) continue;
    const auto put =
        store.put({one.id, stamp_ms, one.described.voxels, key_frame, static_cast<std::uint16_t>(one.version),
                   robot, mapping::offset_of(frame, one.place), one.descriptor});
    if (put.status != Status::ok) return;  // store.counts() has it, too
  }
}

/// Where the local map lies on the kept one: T_kept_local; or why that is not known.
mapping::SetVerdict find_place(const mapping::SegmentWatch& watch, const mapping::TargetStore& store,
                               mapping::Recogniser& recogniser, mapping::LevelPlace& place) {
  mapping::SpeakingSegment speaking[64];
  std::size_t count = 0;
  for (const mapping::WatchedSegment& one : watch.segments()) {
    if (one.speaks && count < 64) speaking[count++] = {one.id, one.version, one.place, one.descriptor};
  }
  recogniser.begin({speaking, count}, {});  // {}: any target, wherever it is
  for (bool done = false; !done;) {
    std::uint64_t units = 500'000;  // of a job
    done = recogniser.run(store, units);
  }
  if (recogniser.verdict() == mapping::SetVerdict::found) place = recogniser.found()[0].fit.place;
  return recogniser.verdict();
}

// --- as on the page, up to here

constexpr double kYaw = 0.6, kMoveX_m = 1.3, kMoveY_m = -0.8;

/// A map of the things of bodies(), each on a spot of its own, made by a robot that has its frame where it
/// began, and two rounds a second and a half apart.
struct Yard {
  static constexpr double kSpot[][2] = {{-9, -9}, {2, -11}, {9, -4},  {8, 5},  {4, 10}, {-3, 9},
                                        {-8, 8},  {-9, 1},  {-4, -4}, {-4, 4}, {4, -4}};
  std::vector<std::byte> memory = std::vector<std::byte>(1 << 20);
  rt::Arena arena{memory};
  mapping::SegmentDescriber describer{512, 64, arena};
  mapping::SegmentWatch watch{{}, arena};
  tests::EuclideanMap map;

  Yard(const mapping::RollingGridConfig& grid, double yaw, double x_m, double y_m)
      : map(grid, {}, {4096, 32768, 8192, 400'000, 512, 1024}) {
    REQUIRE(arena.refused() == 0);
    const std::vector<testing::Body> things = testing::bodies();
    REQUIRE(things.size() == std::size(kSpot));
    std::vector<rt::ScanPoint> points;
    const double c = std::cos(yaw), s = std::sin(yaw);
    for (std::size_t i = 0; i < things.size(); ++i) {
      for (const rt::Vector3& p : things[i].points) {
        const double x = p.x + kSpot[i][0] - x_m, y = p.y + kSpot[i][1] - y_m;
        points.push_back({static_cast<float>(c * x + s * y), static_cast<float>(c * y - s * x),
                          static_cast<float>(p.z), 0, 0});
      }
    }
    REQUIRE(map.map.update(tests::scan_over(points), {{}, {}}, 1).inserted.status == Status::ok);
    for (const rt::Nanoseconds now_ns : {0, 1'500'000'000})
      REQUIRE(describe_segments(map.grid(), map.segmenter(), now_ns, describer, watch));
  }
};
}  // namespace

TEST_CASE("The program of the page on recognition finds a yard again") {
  mapping::RollingGridConfig grid;
  const Yard kept(grid, 0, 0, 0), local(grid, kYaw, kMoveX_m, kMoveY_m);
  CHECK(kept.watch.counts().versions == 11);
  CHECK(local.watch.counts().versions == 11);

  std::vector<std::byte> memory(1'300'000);
  rt::Arena arena(memory);
  mapping::TargetStore store({}, arena);
  mapping::Recogniser recogniser({}, arena);
  INFO("needs " << arena.needed_bytes());
  REQUIRE(arena.refused() == 0);
  mapping::KeyFramePose frame{{1000, -500, 0}, {}};
  REQUIRE(mapping::heading_of(0.6, 0.8, frame.heading));
  REQUIRE(store.set_key_frame(0, frame) == Status::ok);
  keep_segments(kept.watch, 0, 1, 1500, store);
  CHECK(store.kept() == 11);

  // When the kept map is corrected by half a metre, what is recognised lies there.
  for (const std::int32_t x_cm : {0, 50}) {
    frame.place.x = 1000 + x_cm;
    REQUIRE(store.set_key_frame(0, frame) == Status::ok);
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(store.run(units));
    mapping::LevelPlace place;
    REQUIRE(find_place(local.watch, store, recogniser, place) == mapping::SetVerdict::found);
    const mapping::SetHypothesis& found = recogniser.found()[0];
    CHECK(found.count == 11);
    // A segment's mean is off by a voxel at most, since a map made at another heading cuts it otherwise.
    CHECK(found.fit.rms_m < 0.1);
    CHECK(std::hypot(place.x_m - 0.01 * x_cm - kMoveX_m, place.y_m - kMoveY_m) < 0.1);
    CHECK(std::fabs(std::atan2(place.sine, place.cosine) - kYaw) < 0.02);
  }
}
