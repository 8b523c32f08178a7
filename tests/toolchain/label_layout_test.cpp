// SPDX-License-Identifier: BSD-3-Clause
// Texts beside points: none covers another, none leaves the picture, and one that has room stays beside its
// point.
#include "toolchain/report/label_layout.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace sortie::toolchain;

namespace {

constexpr Frame kPicture{60, 40, 800, 400};

LabelBox covered(const PlacedLabel& label, std::string_view text) {
  const double left = label.ends_there ? label.x - label_width(text) : label.x;
  return {left, label.y - 10, left + label_width(text), label.y + 3};
}

int overlaps(const std::vector<LabelBox>& boxes) {
  int count = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const bool beside = boxes[i].right <= boxes[k].left || boxes[k].right <= boxes[i].left;
      const bool above = boxes[i].bottom <= boxes[k].top || boxes[k].bottom <= boxes[i].top;
      count += !beside && !above ? 1 : 0;
    }
  }
  return count;
}

}  // namespace

TEST_CASE("a text that has room stands above and beside its point, left of it near the right edge") {
  const std::vector<PlacedLabel> placed = lay_labels({"a", "b"}, {200, 850}, {200, 200}, kPicture, {});
  REQUIRE(placed.size() == 2);
  CHECK(placed[0].x == 207);
  CHECK(placed[0].y == 194);
  CHECK_FALSE(placed[0].ends_there);
  CHECK_FALSE(placed[0].is_far);
  CHECK(placed[1].x == 843);
  CHECK(placed[1].ends_there);
}

TEST_CASE(
    "texts of points that lie close together do not cover each other, a rule's text, or the picture's edge") {
  std::mt19937 random(20261123);
  INFO("seed 20261123");
  std::uniform_real_distribution<double> share(0, 1);
  for (int picture = 0; picture < 50; ++picture) {
    std::vector<double> x;
    std::vector<double> y;
    std::vector<std::string_view> texts;
    const double spread = picture % 2 == 0 ? 0.15 : 1.0;  // in the middle of the picture, or all over it
    for (int i = 0; i < 16; ++i) {
      x.push_back(460 + 800 * spread * (share(random) - 0.5));
      y.push_back(240 + 400 * spread * (share(random) - 0.5));
      texts.emplace_back(i % 3 == 0 ? "50000 units" : "0.150 m");
    }
    const LabelBox rule{700, 44, 820, 60};
    const std::vector<PlacedLabel> placed = lay_labels(texts, x, y, kPicture, {rule});
    std::vector<LabelBox> boxes{rule};
    for (std::size_t i = 0; i < placed.size(); ++i) {
      boxes.push_back(covered(placed[i], texts[i]));
      CHECK(boxes.back().left >= 60);
      CHECK(boxes.back().right <= 860);
      CHECK(boxes.back().top >= 40);
      CHECK(boxes.back().bottom <= 440);
      CHECK(std::abs(placed[i].x - x[i]) == Approx(7));
    }
    CHECK(overlaps(boxes) == 0);
  }
}

TEST_CASE("more texts than there is room for are all placed") {
  const std::vector<double> same(200, 300.0);
  const std::vector<std::string_view> texts(200, "defaults");
  CHECK(lay_labels(texts, same, same, kPicture, {}).size() == 200);
}
