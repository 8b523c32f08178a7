// SPDX-License-Identifier: BSD-3-Clause
// From segments and targets to a pose: what was planted is found, a budget at a time, from kept bytes, too.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "mapping/recognition/recogniser.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/registration_world.hpp"

namespace {
using namespace sortie;
using mapping::PlaceCm;
using mapping::SetVerdict;

mapping::SegmentDescriptor any_descriptor(testing::Draws& draws) {
  mapping::SegmentDescriptor d;
  for (std::size_t i = 0; i < sizeof(d.step); ++i)
    d.step[i] = static_cast<std::uint8_t>(draws.uniform(0, 256));
  // Sizes, largest first, within a factor of four.
  for (std::size_t i = 0; i < 3; ++i)
    d.step[i] = static_cast<std::uint8_t>(120.0 - 16.0 * static_cast<double>(i) + draws.uniform(0, 32));
  return d;
}

mapping::SegmentDescriptor shaken(mapping::SegmentDescriptor d, testing::Draws& draws) {
  for (auto& step : d.step) {
    step = static_cast<std::uint8_t>(
        std::clamp(static_cast<int>(step) + static_cast<int>(draws.uniform(-6, 7)), 0, 255));
  }
  return d;
}

/// A known map of 300 targets, and a local map of 40 segments of which some are known, turned and moved.
struct Hall {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::TargetStore store;
  std::vector<mapping::SpeakingSegment> segments;
  double cosine{1}, sine{0}, x_cm{}, y_cm{}, z_cm{};

  Hall(int known, testing::Draws& draws)
      : memory(1 << 20), arena(memory), store({512, 8, 200, 48, 500}, arena) {
    REQUIRE(arena.refused() == 0);
    REQUIRE(store.set_key_frame(0, {}) == Status::ok);
    const double yaw = draws.uniform(-3, 3);
    cosine = std::cos(yaw), sine = std::sin(yaw);
    x_cm = draws.uniform(-9'000, 9'000), y_cm = draws.uniform(-9'000, 9'000), z_cm = draws.uniform(-200, 900);
    for (int i = 0; i < 40; ++i) {
      mapping::SpeakingSegment s;
      s.id = static_cast<std::uint32_t>(100 + 3 * i);
      s.version = 1;
      s.place = {whole(draws.uniform(-1'500, 1'500)), whole(draws.uniform(-1'500, 1'500)),
                 whole(draws.uniform(-50, 300))};
      s.descriptor = any_descriptor(draws);
      segments.push_back(s);
    }
    for (int i = 0; i < 300; ++i) {
      mapping::TargetSighting t;
      t.id = static_cast<std::uint32_t>(i);
      t.voxels = 200;
      if (i < known) {
        const PlaceCm& p = segments[static_cast<std::size_t>(i)].place;
        t.offset = {whole(cosine * p.x - sine * p.y + x_cm + draws.uniform(-15, 15)),
                    whole(sine * p.x + cosine * p.y + y_cm + draws.uniform(-15, 15)),
                    whole(p.z + z_cm + draws.uniform(-15, 15))};
        t.descriptor = shaken(segments[static_cast<std::size_t>(i)].descriptor, draws);
      } else {
        t.offset = {whole(draws.uniform(-9'000, 9'000)), whole(draws.uniform(-9'000, 9'000)),
                    whole(draws.uniform(-50, 1'200))};
        t.descriptor = any_descriptor(draws);
      }
      REQUIRE(store.put(t).status == Status::ok);
    }
    std::uint64_t units = ~std::uint64_t{0};
    REQUIRE(store.run(units));
  }
  static std::int32_t whole(double v) { return static_cast<std::int32_t>(std::floor(v)); }
};

struct Owned {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::Recogniser part;

  explicit Owned(const mapping::RecogniserConfig& config = {})
      : memory(3 << 20), arena(memory), part(config, arena) {
    REQUIRE(arena.refused() == 0);
  }
};

bool same_answer(const mapping::Recogniser& a, const mapping::Recogniser& b) {
  if (a.verdict() != b.verdict() || a.found().size() != b.found().size()) return false;
  for (std::size_t h = 0; h < a.found().size(); ++h) {
    const auto &x = a.found()[h], &y = b.found()[h];
    if (x.count != y.count || x.fit.place.x_m != y.fit.place.x_m || x.fit.place.sine != y.fit.place.sine)
      return false;
    for (std::uint32_t i = 0; i < x.count; ++i) {
      if (!(a.pairs()[x.pairs[i]].pair == b.pairs()[y.pairs[i]].pair)) return false;
    }
  }
  return true;
}

constexpr std::uint64_t kEnough = ~std::uint64_t{0};
}  // namespace

TEST_CASE("A local map is found on a known one by its segments, whatever their order and the budgets") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  Owned once, step;
  for (int run = 0; run < 20; ++run) {
    INFO("run " << run);
    Hall hall(14, draws);
    once.part.begin(hall.segments, {});
    std::uint64_t all = kEnough;
    const std::uint64_t before = rt::posix::heap_trap_thread_calls();
    rt::posix::heap_trap_arm();
    const bool found = once.part.run(hall.store, all);
    rt::posix::heap_trap_disarm();
    REQUIRE(found);
    CHECK(rt::posix::heap_trap_thread_calls() == before);
    REQUIRE(once.part.verdict() == SetVerdict::found);
    const mapping::SetHypothesis& best = once.part.found()[0];
    CHECK(best.count >= 12);
    const double x = 0.01 * hall.x_cm, y = 0.01 * hall.y_cm;
    // 12 places and more that are off by 15 cm along each axis at most, over 10 m and more.
    CHECK(std::hypot(best.fit.place.x_m - x, best.fit.place.y_m - y) < 0.5);
    CHECK(std::hypot(best.fit.place.cosine - hall.cosine, best.fit.place.sine - hall.sine) < 0.06);
    std::vector<mapping::SpeakingSegment> shuffled = hall.segments;
    for (std::size_t i = shuffled.size(); i > 1; --i)
      std::swap(shuffled[i - 1],
                shuffled[static_cast<std::size_t>(draws.uniform(0, static_cast<double>(i)))]);
    step.part.begin(shuffled, {});
    std::uint64_t spent = 0;
    for (bool done = false; !done;) {
      const auto given = static_cast<std::uint64_t>(draws.uniform(1, 5'000));
      std::uint64_t units = given;
      done = step.part.run(hall.store, units);
      spent += given - units;
    }
    CHECK(same_answer(once.part, step.part));
    CHECK(spent == kEnough - all);
  }
}

TEST_CASE("Strangers are told from a known map, and nothing from nothing") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  Owned owned;
  int found = 0;
  for (int run = 0; run < 60; ++run) {
    Hall hall(run % 2 == 0 ? 0 : 3, draws);
    owned.part.begin(hall.segments, {});
    std::uint64_t all = kEnough;
    REQUIRE(owned.part.run(hall.store, all));
    found += owned.part.verdict() == SetVerdict::found ? 1 : 0;
  }
  CHECK(found == 0);
  Hall hall(14, draws);
  const std::uint64_t few = owned.part.counts().few;
  owned.part.begin({}, {});
  std::uint64_t all = kEnough;
  CHECK(owned.part.run(hall.store, all));
  CHECK(owned.part.verdict() == SetVerdict::few);
  CHECK(owned.part.counts().few == few + 1);
  mapping::RecogniserConfig tight;
  tight.most_units = 10'000;
  Owned bounded(tight);
  bounded.part.begin(hall.segments, {});
  all = kEnough;
  CHECK(bounded.part.run(hall.store, all));
  CHECK(bounded.part.verdict() == SetVerdict::undecided);
  CHECK(kEnough - all == 10'000);
  // Of more segments than there is room for, those with the lowest ids.
  mapping::RecogniserConfig small;
  small.segments = 10;
  Owned less(small);
  std::reverse(hall.segments.begin(), hall.segments.end());
  less.part.begin(hall.segments, {});
  REQUIRE(less.part.segments().size() == 10);
  for (std::uint32_t i = 0; i < 10; ++i) CHECK(less.part.segments()[i].id == 100 + 3 * i);
}

TEST_CASE("A place that somebody refused is not found again") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  Owned owned;
  for (int run = 0; run < 20; ++run) {
    INFO("run " << run);
    Hall hall(14, draws);
    owned.part.begin(hall.segments, {});
    std::uint64_t all = kEnough;
    REQUIRE(owned.part.run(hall.store, all));
    REQUIRE(owned.part.verdict() == SetVerdict::found);
    const mapping::LevelPlace refused = owned.part.found()[0].fit.place;
    owned.part.refuse();
    CHECK(owned.part.is_searching());
    REQUIRE(owned.part.run(hall.store, all));
    CHECK(owned.part.verdict() != SetVerdict::found);
    for (const mapping::SetHypothesis& other : owned.part.found()) {
      CHECK(std::hypot(other.fit.place.x_m - refused.x_m, other.fit.place.y_m - refused.y_m,
                       other.fit.place.cosine - refused.cosine) > 0.1);
    }
  }
}

TEST_CASE("A search that was kept goes on as it would have, refusals and all") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  Owned straight, kept;
  for (int run = 0; run < 12; ++run) {
    INFO("run " << run);
    Hall hall(12, draws);
    straight.part.begin(hall.segments, {});
    const auto cut = static_cast<int>(draws.uniform(0, 60));
    bool refused = false, is_kept = false;
    for (int step = 0; step < 100'000; ++step) {
      if (step == cut) {
        std::vector<std::uint8_t> bytes;
        const auto write = [&](rt::Archive& archive) { straight.part.archive(archive, hall.store); };
        auto measure = rt::Archive::measuring();
        write(measure);
        REQUIRE(measure.status() == Status::ok);
        bytes.resize(static_cast<std::size_t>(measure.bytes()));
        auto writer = rt::Archive::writing(bytes);
        write(writer);
        REQUIRE(writer.status() == Status::ok);
        auto reader = rt::Archive::reading(bytes);
        kept.part.archive(reader, hall.store);
        REQUIRE(reader.status() == Status::ok);
        is_kept = true;
        REQUIRE(same_answer(straight.part, kept.part));
        REQUIRE(straight.part.is_searching() == kept.part.is_searching());
      }
      std::uint64_t units = 3'000, others = 3'000;
      const bool done = straight.part.run(hall.store, units);
      if (step >= cut) {
        REQUIRE(kept.part.run(hall.store, others) == done);
        REQUIRE(units == others);
      }
      if (!done) continue;
      if (refused) break;
      refused = true;
      straight.part.refuse();
      if (step >= cut) kept.part.refuse();
    }
    if (!is_kept) continue;
    CHECK(same_answer(straight.part, kept.part));
    CHECK(straight.part.counts().begun == kept.part.counts().begun);
    CHECK(straight.part.counts().inconsistent == kept.part.counts().inconsistent);
  }
}
