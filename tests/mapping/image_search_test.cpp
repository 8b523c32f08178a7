// SPDX-License-Identifier: BSD-3-Clause
// Searches among images of drawn places.
#include "mapping/recognition/image_search.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/image_rig.hpp"

namespace {
using namespace sortie;
using mapping::HeightImage;
using mapping::ImagePlace;
using mapping::ImagePlane;
using mapping::ImageSearch;
using mapping::ImageVerdict;
using testing::DrawnPlace;
using testing::DrawnPose;
using testing::Draws;
using testing::OwnedImages;

constexpr std::uint64_t kAllUnits = ~std::uint64_t{0} >> 1;

/// A place, images along it, and one more that is looked for.
struct SearchCase {
  DrawnPlace place;
  OwnedImages kept;
  DrawnPose pose;
  HeightImage seen;

  SearchCase(Draws& draws, int images, int boxes) : place(testing::draw_place(draws, boxes)) {
    const auto anywhere = [&draws] {
      return DrawnPose{draws.uniform(-4, 4), draws.uniform(-3, 3), draws.uniform(-M_PI, M_PI)};
    };
    for (int i = 0; i < images; ++i) {
      const DrawnPose at = anywhere();
      (void)kept.store.put(testing::image_of(place, at, 12, draws), testing::key_frame_of(at), 0, 0);
    }
    pose = anywhere();
    seen = testing::image_of(place, pose, 12, draws);
    seen.middle = {1234, -777, 50};
  }
  /// Metres that a place is off, and degrees.
  std::pair<double, double> off(const mapping::ImageHypothesis& found) const {
    const double yaw = std::atan2(found.place.sine, found.place.cosine);
    const double turn = std::remainder(yaw - pose.yaw, 2 * M_PI) * 180 / M_PI;
    const double x = found.place.cosine * 12.34 - found.place.sine * -7.77 + found.place.x_m;
    const double y = found.place.sine * 12.34 + found.place.cosine * -7.77 + found.place.y_m;
    return {std::hypot(x - pose.x, y - pose.y), std::abs(turn)};
  }
};

/// Everything that a search found, as text.
std::string told(const ImageSearch& search) {
  std::string text = std::to_string(static_cast<int>(search.verdict()));
  for (const mapping::ImageHypothesis& one : search.found()) {
    for (const std::int64_t number :
         {std::int64_t{one.image}, std::int64_t{one.on_image.turn}, std::int64_t{one.on_image.x},
          std::int64_t{one.on_image.y}, std::int64_t{one.score.total()}, std::int64_t{one.middle.x},
          std::int64_t{one.heading.cosine}})
      text += " " + std::to_string(number);
    text += ";";
  }
  return text;
}

std::string search_all(ImageSearch& search, const SearchCase& one, std::uint64_t slice = kAllUnits) {
  search.begin(one.seen);
  for (bool done = false; !done;) {
    std::uint64_t units = slice;
    done = search.run(one.kept.store, units);
    REQUIRE(units <= slice);
  }
  return told(search);
}

}  // namespace

TEST_CASE("No turn and no shift is better than what a search finds", "[heavy]") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const mapping::ImageTurns turns;
  int better = 0;
  for (int round = 0; round < 3; ++round) {
    const SearchCase one(draws, 1, 6);
    ImageSearch search({});
    (void)search_all(search, one);
    REQUIRE_FALSE(search.found().empty());
    mapping::ImageView view;
    view.take(one.kept.store.images()[0].image);
    mapping::ImagePoints points;
    points.take(one.seen);
    // Every turn of 2.8 degrees and every shift of two cells, and all cells about the best of these.
    std::int32_t most = -100'000;
    ImagePlace best;
    const auto look = [&](int turn, int x, int y) {
      const ImagePlace place{static_cast<std::uint16_t>((turn + 512) % 512), static_cast<std::int16_t>(x),
                             static_cast<std::int16_t>(y)};
      const std::int32_t total = view.score(points, turns, place).total();
      if (total <= most) return;
      most = total;
      best = place;
    };
    for (int turn = 0; turn < 512; turn += 4) {
      for (int x = -40; x <= 40; x += 2) {
        for (int y = -40; y <= 40; y += 2) look(turn, x, y);
      }
    }
    const ImagePlace coarse = best;
    for (int turn = -4; turn <= 4; ++turn) {
      for (int x = -3; x <= 3; ++x) {
        for (int y = -3; y <= 3; ++y) look(coarse.turn + turn, coarse.x + x, coarse.y + y);
      }
    }
    INFO("found " << search.found()[0].score.total() << ", all " << most);
    CHECK(search.found()[0].score.total() >= 0.97 * most);
    better += most > search.found()[0].score.total() ? 1 : 0;
    CHECK(std::abs(search.found()[0].on_image.x - best.x) <= 2);
    CHECK(std::abs(search.found()[0].on_image.y - best.y) <= 2);
  }
  INFO(better << " of 3 are a little better");
}

TEST_CASE("A place with things in it is found among images of it, to a cell and a turn") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  int found = 0;
  for (int round = 0; round < 20; ++round) {
    INFO("round " << round);
    const SearchCase one(draws, 6, 8);
    ImageSearch search({});
    (void)search_all(search, one);
    if (search.verdict() != ImageVerdict::found) continue;
    ++found;
    const auto [metres, degrees] = one.off(search.found()[0]);
    CHECK(metres < 0.4);
    CHECK(degrees < 2.0);
  }
  CHECK(found >= 14);
}

TEST_CASE("A search in slices of any size, and one that goes on from stored bytes, finds the same") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  for (int round = 0; round < 3; ++round) {
    const SearchCase one(draws, 4, 6);
    ImageSearch search({}), other({});
    const std::string whole = search_all(search, one);
    for (const std::uint64_t slice : {1'000ull, 70'001ull, 5'000'000ull})
      REQUIRE(search_all(search, one, slice) == whole);
    std::uint64_t all = kAllUnits;
    search.begin(one.seen);
    (void)search.run(one.kept.store, all);
    const std::uint64_t needed = kAllUnits - all;
    for (const double share : {0.0, 0.01, 0.3, 0.7, 0.999, 1.0}) {
      INFO("share " << share);
      search.begin(one.seen);
      auto units = static_cast<std::uint64_t>(share * static_cast<double>(needed));
      (void)search.run(one.kept.store, units);
      rt::Archive counter = rt::Archive::measuring();
      search.archive(counter, one.kept.store);
      REQUIRE(counter.status() == Status::ok);
      std::vector<std::uint8_t> bytes(counter.bytes());
      rt::Archive writer = rt::Archive::writing(bytes);
      search.archive(writer, one.kept.store);
      rt::Archive reader = rt::Archive::reading(bytes);
      other.archive(reader, one.kept.store);
      REQUIRE(reader.status() == Status::ok);
      REQUIRE(other.is_searching() == search.is_searching());
      std::uint64_t left = kAllUnits, other_left = kAllUnits;
      (void)search.run(one.kept.store, left);
      (void)other.run(one.kept.store, other_left);
      REQUIRE(left == other_left);
      REQUIRE(told(other) == told(search));
      REQUIRE(told(other) == whole);
    }
  }
}

TEST_CASE("More units never tell less: undecided up to some number, and the whole answer from there") {
  Draws draws(5);
  const SearchCase one(draws, 3, 6);
  mapping::ImageSearchConfig config;
  ImageSearch all(config);
  const std::string whole = search_all(all, one);
  int decided = 0;
  for (std::uint32_t units = 20'000; units < 200'000'000; units *= 3) {
    config.most_units = units;
    ImageSearch search(config);
    const std::string text = search_all(search, one);
    if (search.verdict() == ImageVerdict::undecided) {
      CHECK(decided == 0);
      CHECK(search.found().empty());
    } else {
      ++decided;
      CHECK(text == whole);
    }
  }
  CHECK(decided > 0);
}

TEST_CASE("What an image does not say is said") {
  Draws draws(6);
  OwnedImages owned;
  ImageSearch search({});
  const auto ask = [&](const HeightImage& image) {
    search.begin(image);
    std::uint64_t units = kAllUnits;
    REQUIRE(search.run(owned.store, units));
    return search.verdict();
  };
  const auto keep = [&](const DrawnPlace& place, const DrawnPose& from, const DrawnPose& at) {
    REQUIRE(owned.store.put(testing::image_of(place, from, 12, draws), testing::key_frame_of(at), 0, 0) ==
            Status::ok);
  };
  const DrawnPlace room = testing::draw_place(draws, 8);
  const HeightImage seen = testing::image_of(room, {1, 1, 0.3}, 12, draws);
  CHECK(ask(seen) == ImageVerdict::few);  // no images
  keep(room, {0, 0, 0}, {0, 0, 0});
  CHECK(ask({}) == ImageVerdict::few);  // nothing to go by
  REQUIRE(ask(seen) == ImageVerdict::found);
  search.refuse(owned.store);
  CHECK(search.verdict() != ImageVerdict::none);
  CHECK(search.counts().begun == 4);
  // The same room once more elsewhere.
  keep(room, {0, 0, 0}, {50, 0, 1});
  CHECK(ask(seen) == ImageVerdict::ambiguous);
  // A corridor without ends can be moved along itself.
  owned.store.clear();
  DrawnPlace corridor;
  corridor.box(-60, -1.2, 60, 1.2);
  keep(corridor, {0, 0, 0.5}, {0, 0, 0.5});
  REQUIRE(ask(testing::image_of(corridor, {3, 0.2, -0.4}, 12, draws)) == ImageVerdict::narrow);
  CHECK(std::abs(search.flat().sine) < 0.35 * mapping::Heading::kOne);
  // Another place.
  owned.store.clear();
  keep(room, {0, 0, 0}, {0, 0, 0});
  DrawnPlace cross;
  cross.box(-60, -60, 60, 60);
  for (int i = 0; i < 25; ++i) {
    const double x = draws.uniform(-9, 9), y = draws.uniform(-9, 9);
    cross.box(x, y, x + 0.6, y + 0.6);
  }
  CHECK(ask(testing::image_of(cross, {0, 0, 0.2}, 12, draws)) == ImageVerdict::unlike);
}

TEST_CASE("A room that looks the same from both ends is ambiguous: both turns are told") {
  Draws draws(9);
  OwnedImages owned;
  DrawnPlace room;
  room.box(-7, -4, 7, 4);
  REQUIRE(owned.store.put(testing::image_of(room, {0, 0, 0.4}, 12, draws), testing::key_frame_of({0, 0, 0.4}),
                          0, 0) == Status::ok);
  ImageSearch search({});
  search.begin(testing::image_of(room, {1, 0.5, -1}, 12, draws));
  std::uint64_t units = kAllUnits;
  REQUIRE(search.run(owned.store, units));
  REQUIRE(search.verdict() == ImageVerdict::ambiguous);
  const mapping::LevelPlace &one = search.found()[0].place, &other = search.found()[1].place;
  CHECK(one.cosine * other.cosine + one.sine * other.sine < -0.99);
}

TEST_CASE("A search takes no heap") {
  Draws draws(8);
  const SearchCase one(draws, 3, 6);
  ImageSearch search({});
  const rt::posix::HeapTrapScope scope;
  search.begin(one.seen);
  std::uint64_t units = kAllUnits;
  (void)search.run(one.kept.store, units);
  if (rt::posix::kHeapTrapAvailable) CHECK(scope.calls() == 0);
}
