// SPDX-License-Identifier: BSD-3-Clause
// A recogniser shows nothing of a search that is over, and is not put off by what is too far away.
#include <catch2/catch.hpp>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "tests/mapping/target_rig.hpp"

namespace {
using namespace sortie;
using mapping::SetVerdict;

/// A map whose targets are the segments of a local map, one each.
struct Known {
  std::vector<std::byte> memory = std::vector<std::byte>(3 << 20);
  rt::Arena arena{memory};
  mapping::TargetStore store{{256, 4, 0, 0, 500}, arena};
  mapping::Recogniser part{{}, arena};
  std::vector<mapping::SpeakingSegment> segments;

  Known(std::uint32_t count, testing::TargetDraws& draws) {
    REQUIRE(arena.refused() == 0);
    REQUIRE(store.set_key_frame(0, {}) == Status::ok);
    for (std::uint32_t id = 0; id < count; ++id) {
      mapping::SpeakingSegment one{id, 1, draws.place(1'500), {}};
      // No two look alike.
      for (auto& step : one.descriptor.step) step = draws.byte(100, 115);
      one.descriptor.step[7] = static_cast<std::uint8_t>(8 * id);
      segments.push_back(one);
      put(one, 0, one.place, 1);
    }
  }
  void put(const mapping::SpeakingSegment& one, std::uint16_t key_frame, const mapping::PlaceCm& offset,
           std::uint8_t robot) {
    mapping::TargetSighting seen;
    seen.id = one.id;
    seen.key_frame = key_frame;
    seen.robot = robot;
    seen.offset = offset;
    seen.descriptor = one.descriptor;
    REQUIRE(store.put(seen).status == Status::ok);
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(store.run(units));
  }
  SetVerdict ask() {
    part.begin(segments, {});
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(part.run(store, units));
    return part.verdict();
  }
};

/// Writes one end of each number's range.
struct ToEnd {
  bool high;
  void operator()(const char*, double& value, const rt::KeySpec& range) const {
    value = high ? range.high : range.low;
  }
  template <class T>
  void operator()(const char*, T&, const rt::KeySpec&) const {}
};
}  // namespace

TEST_CASE("A search that begins shows nothing of the one before, nor does one that is put back") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  Known known(16, draws), never(16, draws);
  REQUIRE(known.ask() == SetVerdict::found);
  REQUIRE(known.part.found().size() == 1);
  known.part.begin(known.segments, {});
  CHECK(known.part.found().empty());
  std::uint64_t one = 1;
  CHECK_FALSE(known.part.run(known.store, one));
  CHECK(known.part.found().empty());
  known.part.refuse();
  CHECK(known.part.is_searching());
  REQUIRE(known.ask() == SetVerdict::found);
  auto measure = rt::Archive::measuring();
  never.part.archive(measure, known.store);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  auto writer = rt::Archive::writing(bytes);
  never.part.archive(writer, known.store);
  auto reader = rt::Archive::reading(bytes);
  known.part.archive(reader, known.store);
  REQUIRE(reader.status() == Status::ok);
  CHECK(known.part.verdict() == SetVerdict::none);
  CHECK_FALSE(known.part.is_searching());
  CHECK(known.part.found().empty());
  CHECK(known.part.counts().begun == 0);
}

TEST_CASE("What is too far away to be compared keeps nothing else from being recognised") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::TargetDraws draws(seed);
  constexpr std::int32_t kFar = mapping::KeyFramePose::kFarthestCm, kOff = mapping::kFarthestOffsetCm;
  for (const mapping::PlaceCm& far : {mapping::PlaceCm{kFar, 0, 0}, {0, -kFar, 0}, {0, 0, kFar}}) {
    Known known(16, draws);
    // Looks like one of them, and another robot has seen it as far away as may be.
    REQUIRE(known.store.set_key_frame(1, {far, {}}) == Status::ok);
    known.put(known.segments[3], 1, {kOff, -kOff, kOff}, 2);
    CHECK(known.ask() == SetVerdict::found);
    CHECK(known.part.found()[0].count == 16);
    known.segments[5].place = {2 * (far.x / 3 * 2), 2 * (far.y / 3 * 2), 2 * (far.z / 3 * 2)};
    CHECK(known.ask() == SetVerdict::found);
    CHECK(known.part.found()[0].count == 15);
  }
}

TEST_CASE("At the ends of their ranges settings are such that places can be compared") {
  std::vector<std::byte> memory(1 << 20);
  rt::Arena arena(memory);
  mapping::SetHypotheses sets(32, arena);
  REQUIRE(arena.refused() == 0);
  for (const bool high : {false, true}) {
    mapping::SetConfig config;
    mapping::SetConfig::keys(config, ToEnd{high});
    CHECK(sets.begin(config, std::vector<mapping::SweptPair>(20)) == Status::ok);
  }
}
