// SPDX-License-Identifier: BSD-3-Clause
// Counts of cells and of shifts, and scores of places, beside counts one by one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "mapping/recognition/image_planes.hpp"
#include "mapping/recognition/image_search.hpp"
#include "mapping/recognition/shift_counts.hpp"
#include "tests/mapping/image_rig.hpp"

namespace {
using namespace sortie;
using mapping::HeightImage;
using mapping::ImagePlace;
using mapping::ImagePlane;
using testing::Draws;

bool holds(const ImagePlane& plane, std::int32_t x, std::int32_t y) {
  return ImagePlane::holds(x, y) && plane.at(x, y);
}
bool is_beside(const ImagePlane& plane, std::int32_t x, std::int32_t y) {
  return holds(plane, x, y) || holds(plane, x - 1, y) || holds(plane, x + 1, y) || holds(plane, x, y - 1) ||
         holds(plane, x, y + 1);
}
bool stands(const HeightImage& image, std::int32_t x, std::int32_t y) {
  return holds(image.low, x, y) || holds(image.high, x, y);
}
bool stands_about(const HeightImage& image, std::int32_t x, std::int32_t y) {
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      if (stands(image, x + dx, y + dy)) return true;
    }
  }
  return false;
}

/// What ImageView::score() gives, cell by cell, in numbers with a fraction; all cells are taken. `unsure`
/// counts those so near a border that the code's rounding may put them on its other side.
mapping::ImageScore twin_score(const HeightImage& kept, const HeightImage& seen, const ImagePlace& place,
                               int& unsure) {
  mapping::ImageScore score;
  unsure = 0;
  const double angle = 2.0 * M_PI * place.turn / 512, c = std::cos(angle), s = std::sin(angle);
  for (std::int32_t y = 0; y < 128; ++y) {
    for (std::int32_t x = 0; x < 128; ++x) {
      const double mx = x - 63.5, my = y - 63.5;
      const double u = c * mx - s * my, v = s * mx + c * my;
      const bool counts = stands(seen, x, y) || holds(seen.floor, x, y);
      if (counts && std::min(std::fabs(u - std::round(u)), std::fabs(v - std::round(v))) < 1e-6) ++unsure;
      const auto column = static_cast<std::int32_t>(std::floor(u + 1e-7)) + 64 + place.x;
      const auto row = static_cast<std::int32_t>(std::floor(v + 1e-7)) + 64 + place.y;
      if (!ImagePlane::holds(column, row)) continue;
      if (stands(seen, x, y)) {
        const bool agrees = (holds(seen.low, x, y) && is_beside(kept.low, column, row)) ||
                            (holds(seen.high, x, y) && is_beside(kept.high, column, row));
        if (agrees) {
          ++score.agree;
        } else if (holds(kept.floor, column, row) && !stands_about(kept, column, row)) {
          ++score.against;
        }
      } else if (holds(seen.floor, x, y) && !stands_about(seen, x, y) && stands(kept, column, row)) {
        ++score.floor_against;
      }
    }
  }
  return score;
}

HeightImage noise_image(Draws& draws, double share) {
  HeightImage image;
  for (std::int32_t y = 0; y < 128; ++y) {
    for (std::int32_t x = 0; x < 128; ++x) {
      if (draws.uniform(0, 1) < share) image.low.set(x, y);
      if (draws.uniform(0, 1) < share) image.high.set(x, y);
      if (draws.uniform(0, 1) < 0.05) image.floor.set(x, y);
    }
  }
  return image;
}

}  // namespace

TEST_CASE("Counts of many shifts at a time are those of each shift alone") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  for (const int words : {0, 1, 7, 8, 9, 100, 1023}) {
    mapping::ShiftCounts<2> counts;
    std::uint32_t twin[128]{};
    for (int i = 0; i < words; ++i) {
      const std::uint64_t dense = words == 1023 ? ~std::uint64_t{0} : random();
      const std::uint64_t bits[2] = {dense | random(), random()};
      counts.add(bits);
      for (unsigned b = 0; b < 128; ++b) twin[b] += static_cast<std::uint32_t>(bits[b / 64] >> (b % 64) & 1);
    }
    counts.flush();
    for (int w = 0; w < 2; ++w) {
      std::uint64_t which = 0;
      const std::uint32_t most = counts.most(w, which);
      const auto least = static_cast<std::uint32_t>(random() % 1024);
      const std::uint64_t over = counts.at_least(w, least);
      std::uint32_t twin_most = 0;
      for (unsigned b = 0; b < 64; ++b) {
        const std::uint32_t own = twin[64 * w + static_cast<int>(b)];
        REQUIRE(counts.count(w, b) == own);
        REQUIRE((over >> b & 1) == (own >= least ? 1 : 0));
        twin_most = std::max(twin_most, own);
      }
      REQUIRE(most == twin_most);
      for (unsigned b = 0; b < 64; ++b)
        REQUIRE((which >> b & 1) == (twin[64 * w + static_cast<int>(b)] == most ? 1 : 0));
    }
  }
}

TEST_CASE("Rows of an image are its cells, one by one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const HeightImage image = noise_image(draws, 0.02);
  mapping::ImageView view;
  view.take(image);
  for (std::int32_t y = 0; y < 128; ++y) {
    for (const std::int32_t x : {0, 1, 31, 63, 64, 65, 100, 127}) {
      std::uint64_t near[2], free[2];
      view.near_row(x, y, near);
      view.free_row(x, y, free);
      for (std::int32_t i = 0; i < 128; ++i) {
        const std::int32_t at = x + i - 64;
        const bool is_near =
            ImagePlane::holds(at, y) && (is_beside(image.low, at, y) || is_beside(image.high, at, y));
        REQUIRE((near[i / 64] >> (i % 64) & 1) == (is_near ? 1 : 0));
        const bool is_free = holds(image.floor, at, y) && !stands_about(image, at, y);
        REQUIRE((free[i / 64] >> (i % 64) & 1) == (is_free ? 1 : 0));
      }
    }
  }
  const auto stands_coarse = [&image](std::int32_t x, std::int32_t y) {
    for (std::int32_t i = 0; i < 4; ++i) {
      if (stands(image, 2 * x + i % 2, 2 * y + i / 2)) return true;
    }
    return false;
  };
  for (std::int32_t y = 0; y < 64; ++y) {
    for (const std::int32_t x : {0, 1, 31, 32, 33, 63}) {
      const std::uint64_t row = view.coarse_row(x, y);
      for (std::int32_t i = 0; i < 64; ++i) {
        const std::int32_t at = x + i - 32;
        const bool is_near = at >= 0 && at < 64 &&
                             (stands_coarse(at, y) || stands_coarse(at - 1, y) || stands_coarse(at + 1, y) ||
                              stands_coarse(at, y - 1) || stands_coarse(at, y + 1));
        REQUIRE((row >> i & 1) == (is_near ? 1 : 0));
      }
    }
  }
}

TEST_CASE("A score counts cells that agree and cells that do not, as one by one") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  Draws draws(seed);
  const mapping::ImageTurns turns;
  for (int round = 0; round < 20; ++round) {
    const HeightImage kept = noise_image(draws, 0.03), seen = noise_image(draws, 0.015);
    mapping::ImageView view;
    view.take(kept);
    mapping::ImagePoints points;
    points.take(seen);
    REQUIRE(points.floor_weight() == 1);
    const ImagePlace place{static_cast<std::uint16_t>(draws.uniform(0, 512)),
                           static_cast<std::int16_t>(draws.uniform(-70, 70)),
                           static_cast<std::int16_t>(draws.uniform(-70, 70))};
    INFO("turn " << place.turn << " x " << place.x << " y " << place.y);
    int unsure = 0;
    const mapping::ImageScore score = view.score(points, turns, place),
                              twin = twin_score(kept, seen, place, unsure);
    const auto apart = [](auto a, auto b) { return std::abs(static_cast<int>(a) - static_cast<int>(b)); };
    CHECK(apart(score.agree, twin.agree) <= unsure);
    CHECK(apart(score.against, twin.against) <= unsure);
    CHECK(apart(score.floor_against, twin.floor_against) <= unsure);
  }
}
