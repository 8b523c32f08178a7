// SPDX-License-Identifier: BSD-3-Clause
// Images laid on each other, and places that only look alike.
#include "mapping/recognition/image_laid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "mapping/recognition/image_search.hpp"
#include "tests/mapping/image_rig.hpp"

namespace {
using namespace sortie;
using mapping::HeightImage;
using mapping::ImagePlace;
using mapping::ImagePlane;
using mapping::ImageVerdict;
using testing::DrawnPlace;
using testing::DrawnPose;
using testing::Draws;
using testing::OwnedImages;

bool is_in(const ImagePlane& plane, int x, int y) { return ImagePlane::holds(x, y) && plane.at(x, y); }

/// One of these about a cell, up to `reach` along x and along y, of those up to `sum` along both.
bool is_about(const ImagePlane& plane, int x, int y, int reach, int sum) {
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (std::abs(dx) + std::abs(dy) <= sum && is_in(plane, x + dx, y + dy)) return true;
    }
  }
  return false;
}

/// What laid_on() and laid_below() give, cell by cell, in numbers with a fraction; `unsure` counts cells so
/// near a border that the code's rounding may put them on its other side.
mapping::CellsLaid twin_laid(const HeightImage& cells, const HeightImage& view, const ImagePlace& place,
                             bool below, std::uint32_t& unsure) {
  mapping::CellsLaid out;
  unsure = 0;
  const double angle = 2.0 * M_PI * place.turn / 512, c = std::cos(angle), s = std::sin(angle);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const bool low = cells.low.at(x, y), high = cells.high.at(x, y);
      if (!low && !high) continue;
      const double mx = x - 63.5, my = y - 63.5, bx = mx - place.x, by = my - place.y;
      const double u = below ? c * bx + s * by : c * mx - s * my + place.x;
      const double v = below ? c * by - s * bx : s * mx + c * my + place.y;
      if (std::min(std::fabs(u - std::round(u)), std::fabs(v - std::round(v))) < 1e-6) ++unsure;
      const auto column = static_cast<int>(std::floor(u + 1e-7)) + 64;
      const auto row = static_cast<int>(std::floor(v + 1e-7)) + 64;
      if (!ImagePlane::holds(column, row)) continue;
      if (!is_about(view.floor, column, row, 2, 4) && !is_about(view.low, column, row, 2, 4) &&
          !is_about(view.high, column, row, 2, 4))
        continue;
      ++out.known;
      const bool agrees =
          (low && is_about(view.low, column, row, 1, 1)) || (high && is_about(view.high, column, row, 1, 1));
      out.agree += agrees ? 1 : 0;
    }
  }
  return out;
}

/// A corridor of 2 m along x with niches 1 m wide and 0.6 m deep so far from its
/// beginning; below zero on the right.
DrawnPlace niches_along(const std::vector<double>& at, double half_x) {
  DrawnPlace place;
  place.box(-half_x, -1, half_x, 1);
  for (DrawnPlace::Wall* side = &place.walls[0]; side != &place.walls[2]; ++side)
    side->low = side->high = false;
  for (const double side : {-1.0, 1.0}) {
    double from = -half_x;
    for (const double x : at) {
      if (side * x < 0) continue;
      const double begin = std::abs(x) - half_x, deep = side * 1.6;
      place.walls.push_back({from, side, begin, side, true, true});
      place.walls.push_back({begin, side, begin, deep, true, true});
      place.walls.push_back({begin, deep, begin + 1, deep, true, true});
      place.walls.push_back({begin + 1, deep, begin + 1, side, true, true});
      from = begin + 1;
    }
    place.walls.push_back({from, side, half_x, side, true, true});
  }
  return place;
}

}  // namespace

TEST_CASE("Cells on an image, and below it, agree as one by one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const mapping::ImageTurns turns;
  mapping::ImageView view;
  mapping::ImagePoints points;
  const auto noise = [&draws](double share) {
    HeightImage image;
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        if (draws.uniform(0, 1) < share) image.low.set(x, y);
        if (draws.uniform(0, 1) < share) image.high.set(x, y);
        if (draws.uniform(0, 1) < share) image.floor.set(x, y);
      }
    }
    return image;
  };
  for (int round = 0; round < 30; ++round) {
    const HeightImage cells = noise(0.02), other = noise(0.02);
    const ImagePlace place{static_cast<std::uint16_t>(draws.uniform(0, 512)),
                           static_cast<std::int16_t>(draws.uniform(-70, 70)),
                           static_cast<std::int16_t>(draws.uniform(-70, 70))};
    INFO("turn " << place.turn << " x " << place.x << " y " << place.y);
    view.take(other);
    points.take(cells);
    for (const bool below : {false, true}) {
      const mapping::CellsLaid laid = below ? mapping::laid_below(points.standing(), view, turns, place)
                                            : mapping::laid_on(points.standing(), view, turns, place);
      std::uint32_t unsure = 0;
      const mapping::CellsLaid twin = twin_laid(cells, other, place, below, unsure);
      const auto apart = [](auto a, auto b) { return std::abs(static_cast<int>(a) - static_cast<int>(b)); };
      CHECK(apart(laid.known, twin.known) <= static_cast<int>(unsure));
      CHECK(apart(laid.agree, twin.agree) <= static_cast<int>(unsure));
    }
  }
}

TEST_CASE("Cells are laid on an image and below it as their poses say") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const mapping::ImageTurns turns;
  mapping::ImageView view;
  mapping::ImagePoints points;
  for (int round = 0; round < 10; ++round) {
    const DrawnPlace room = testing::draw_place(draws, 6);
    const DrawnPose at{draws.uniform(-2, 2), draws.uniform(-2, 2), 0.0};
    view.take(testing::image_of(room, {0, 0, 0}, 12, draws));
    const std::uint16_t turn = static_cast<std::uint16_t>(draws.uniform(0, 512));
    const double yaw = 2 * M_PI * turn / 512;
    const HeightImage seen = testing::image_of(room, {at.x, at.y, yaw}, 12, draws);
    points.take(seen);
    const ImagePlace place{turn, static_cast<std::int16_t>(std::lround(5 * at.x)),
                           static_cast<std::int16_t>(std::lround(5 * at.y))};
    const mapping::CellsLaid on = mapping::laid_on(points.standing(), view, turns, place);
    INFO("round " << round << " known " << on.known << " agree " << on.agree);
    CHECK(on.known >= 0.9 * static_cast<double>(points.standing().size()));
    CHECK(on.agree >= 0.95 * on.known);
    // The other way about, of the other image's cells.
    points.take(testing::image_of(room, {0, 0, 0}, 12, draws));
    view.take(seen);
    const mapping::CellsLaid below = mapping::laid_below(points.standing(), view, turns, place);
    CHECK(below.known >= 0.9 * static_cast<double>(points.standing().size()));
    CHECK(below.agree >= 0.95 * below.known);
    view.take(testing::image_of(room, {0, 0, 0}, 12, draws));
    ImagePlace off = place;
    off.x = static_cast<std::int16_t>(off.x + 9);
    points.take(seen);
    CHECK(mapping::laid_on(points.standing(), view, turns, off).agree < 0.9 * on.agree);
  }
}

TEST_CASE("A place that was kept twice is ambiguous, however many images lie between") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  for (int round = 0; round < 4; ++round) {
    const DrawnPlace room = testing::draw_place(draws, 8);
    OwnedImages owned;
    const auto keep = [&](const DrawnPlace& place, const DrawnPose& from, const DrawnPose& at) {
      REQUIRE(owned.store.put(testing::image_of(place, from, 12, draws), testing::key_frame_of(at), 0, 0) ==
              Status::ok);
    };
    for (const double x : {-3.0, 0.0, 3.0}) keep(room, {x, 0, 0}, {x, 0, 0});
    for (int i = 0; i < 20; ++i) keep(testing::draw_place(draws, 6), {}, {100.0 + 20 * i, 0, 0});
    keep(room, {1, -1, 1}, {50, 50, 2});
    mapping::ImageSearch search({});
    search.begin(testing::image_of(room, {0.4, 0.6, -2}, 12, draws));
    std::uint64_t units = ~std::uint64_t{0} >> 1;
    REQUIRE(search.run(owned.store, units));
    CHECK(search.verdict() != ImageVerdict::found);
  }
}

TEST_CASE("Niches that come again and again are no place, niches that do not are one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const auto ask = [&](const DrawnPlace& place, double x) {
    OwnedImages owned;
    REQUIRE(owned.store.put(testing::image_of(place, {0, 0, 0.3}, 12, draws),
                            testing::key_frame_of({0, 0, 0.3}), 0, 0) == Status::ok);
    mapping::ImageSearch search({});
    search.begin(testing::image_of(place, {x, 0.1, -0.4}, 12, draws));
    std::uint64_t units = ~std::uint64_t{0} >> 1;
    REQUIRE(search.run(owned.store, units));
    return search.verdict();
  };
  std::vector<double> often;
  for (double at = 2; at < 58; at += 3) {
    often.push_back(at);
    often.push_back(-at);
  }
  CHECK(ask(niches_along(often, 30), 1.0) != ImageVerdict::found);
  CHECK(ask(niches_along({}, 30), 1.0) != ImageVerdict::found);
  // Drawn niches may look alike from two places by chance: 1 of 15 does.
  int found = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<double> seldom;
    for (const double side : {-1.0, 1.0}) {
      for (double at = 2; at < 57; at += draws.uniform(2.0, 5.5)) seldom.push_back(side * at);
    }
    found += ask(niches_along(seldom, 30), 1.0) == ImageVerdict::found ? 1 : 0;
  }
  CHECK(found >= 28);
}

TEST_CASE("Another corridor of the same size is not found, with as many niches elsewhere") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const auto corridor = [&draws] {
    std::vector<double> at;
    for (const double side : {-1.0, 1.0}) {
      for (double x = 2; x < 57; x += draws.uniform(2.0, 5.5)) at.push_back(side * x);
    }
    return niches_along(at, 30);
  };
  mapping::ImageSearch search({});
  for (int round = 0; round < 30; ++round) {
    OwnedImages owned;
    REQUIRE(owned.store.put(testing::image_of(corridor(), {0, 0, 0.3}, 12, draws),
                            testing::key_frame_of({0, 0, 0.3}), 0, 0) == Status::ok);
    search.begin(testing::image_of(corridor(), {1, 0.1, -0.4}, 12, draws));
    std::uint64_t units = ~std::uint64_t{0} >> 1;
    REQUIRE(search.run(owned.store, units));
    INFO("round " << round);
    CHECK(search.verdict() != ImageVerdict::found);
  }
}
