// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/density_features.hpp"

#include <array>
#include <bit>
#include <utility>

#include "tests/bench/recognition/density_image.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::bench {
namespace {

constexpr double kCorner = 35.0;
constexpr std::size_t kMost = 500;
constexpr int kPatch = 15;  ///< radius, pixels
constexpr int kAlike = 35, kNear = 50;
constexpr double kAgree = 3.0;
constexpr int kTrials = 300;  ///< published: 74, for 30 % that are right

struct Offset {
  int x, y;
};
constexpr Offset kCircle[16] = {{0, -3}, {1, -3}, {2, -2}, {3, -1}, {3, 0},  {3, 1},   {2, 2},   {1, 3},
                                {0, 3},  {-1, 3}, {-2, 2}, {-3, 1}, {-3, 0}, {-3, -1}, {-2, -2}, {-1, -3}};

/// The largest difference by which nine pixels in a row of the circle are all brighter, or all darker.
double cornerness(const DensityImage& image, int x, int y) {
  double more[16];
  for (int i = 0; i < 16; ++i) more[i] = image.at(x + kCircle[i].x, y + kCircle[i].y) - image.at(x, y);
  double best = 0.0;
  for (int first = 0; first < 16; ++first) {
    double bright = 1e9, dark = 1e9;
    for (int i = first; i < first + 9; ++i) {
      bright = std::min(bright, more[i % 16]);
      dark = std::min(dark, -more[i % 16]);
    }
    best = std::max({best, bright, dark});
  }
  return best;
}

/// Harris' measure over 7 by 7 pixels.
double harris(const DensityImage& image, int x, int y) {
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (int v = y - 3; v <= y + 3; ++v) {
    for (int u = x - 3; u <= x + 3; ++u) {
      const auto at = [&](int dx, int dy) { return image.at(u + dx, v + dy); };
      const double gx = at(1, -1) + 2 * at(1, 0) + at(1, 1) - at(-1, -1) - 2 * at(-1, 0) - at(-1, 1);
      const double gy = at(-1, 1) + 2 * at(0, 1) + at(1, 1) - at(-1, -1) - 2 * at(0, -1) - at(1, -1);
      xx += gx * gx;
      yy += gy * gy;
      xy += gx * gy;
    }
  }
  return xx * yy - xy * xy - 0.04 * (xx + yy) * (xx + yy);
}

struct Corner {
  int x, y;
  double measure;
};

/// Those that are no less of a corner than what is beside them, the strongest first.
std::vector<Corner> corners_of(const DensityImage& image) {
  constexpr int kBorder = DensityImage::kMargin - 4;  // a corner may lie just beyond what is not black
  DensityImage score = image;
  std::fill(score.pixels.begin(), score.pixels.end(), 0.0);
  for (int y = kBorder; y < image.height - kBorder; ++y) {
    for (int x = kBorder; x < image.width - kBorder; ++x) {
      const double value = cornerness(image, x, y);
      score.at(x, y) = value > kCorner ? value : 0.0;
    }
  }
  std::vector<Corner> corners;
  for (int y = kBorder; y < image.height - kBorder; ++y) {
    for (int x = kBorder; x < image.width - kBorder; ++x) {
      bool is_most = score.at(x, y) > 0.0;
      for (int i = 0; i < 9 && is_most; ++i) {
        const double beside = score.at(x + i % 3 - 1, y + i / 3 - 1);
        is_most = i < 4 ? beside < score.at(x, y) : beside <= score.at(x, y);
      }
      if (is_most) corners.push_back({x, y, harris(image, x, y)});
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.measure > b.measure; });
  if (corners.size() > kMost) corners.resize(kMost);
  return corners;
}

struct Comparison {
  double ax, ay, bx, by;
};

/// Drawn once, about the middle, within what may be turned.
const std::array<Comparison, 256>& comparisons() {
  static const std::array<Comparison, 256> drawn = [] {
    testing::Draws draws(256);
    const auto place = [&draws] {
      for (;;) {
        const double x = 6.2 * draws.normal(), y = 6.2 * draws.normal();
        if (std::hypot(x, y) < kPatch - 1) return std::pair{x, y};
      }
    };
    std::array<Comparison, 256> all;
    for (Comparison& one : all) {
      const auto [ax, ay] = place();
      const auto [bx, by] = place();
      one = {ax, ay, bx, by};
    }
    return all;
  }();
  return drawn;
}

DensityFeature described(const DensityImage& image, const DensityImage& smooth, const Corner& corner) {
  double along_x = 0.0, along_y = 0.0;
  for (int v = -kPatch; v <= kPatch; ++v) {
    for (int u = -kPatch; u <= kPatch; ++u) {
      if (u * u + v * v > kPatch * kPatch) continue;
      along_x += u * image.at(corner.x + u, corner.y + v);
      along_y += v * image.at(corner.x + u, corner.y + v);
    }
  }
  const double length = std::hypot(along_x, along_y);
  const double c = length > 0.0 ? along_x / length : 1.0, s = length > 0.0 ? along_y / length : 0.0;
  const auto value = [&](double x, double y) {
    return smooth.at(corner.x + static_cast<int>(std::lround(c * x - s * y)),
                     corner.y + static_cast<int>(std::lround(s * x + c * y)));
  };
  DensityFeature feature{static_cast<double>(image.first_x + corner.x),
                         static_cast<double>(image.first_y + corner.y)};
  for (std::size_t i = 0; i < 256; ++i) {
    const Comparison& one = comparisons()[i];
    if (value(one.ax, one.ay) < value(one.bx, one.by)) feature.bits[i / 64] |= std::uint64_t{1} << i % 64;
  }
  return feature;
}

int bits_apart(const DensityFeature& a, const DensityFeature& b) {
  int sum = 0;
  for (int i = 0; i < 4; ++i) sum += std::popcount(a.bits[i] ^ b.bits[i]);
  return sum;
}

struct Match {
  const DensityFeature* known;
  const DensityFeature* asked;
};

std::uint32_t agreeing(const std::vector<Match>& matches, const Match& one, const Match& other) {
  // The turn of what lies between the two, and the move of their middle.
  const auto between = [](const DensityFeature* a, const DensityFeature* b) {
    return std::pair{b->x - a->x, b->y - a->y};
  };
  const auto [ax, ay] = between(one.asked, other.asked);
  const auto [kx, ky] = between(one.known, other.known);
  const double c = ax * kx + ay * ky, s = ax * ky - ay * kx, length = std::hypot(c, s);
  if (length == 0.0) return 0;
  const auto middle = [](double a, double b) { return 0.5 * (a + b); };
  const double of_x = middle(one.asked->x, other.asked->x), of_y = middle(one.asked->y, other.asked->y);
  const double to_x = middle(one.known->x, other.known->x), to_y = middle(one.known->y, other.known->y);
  std::uint32_t count = 0;
  for (const Match& match : matches) {
    const double x = match.asked->x - of_x, y = match.asked->y - of_y;
    const double off_x = to_x + (c * x - s * y) / length - match.known->x;
    const double off_y = to_y + (s * x + c * y) / length - match.known->y;
    if (off_x * off_x + off_y * off_y < kAgree * kAgree) ++count;
  }
  return count;
}

}  // namespace

std::vector<DensityFeature> density_features(const std::vector<rt::Vector3>& places, double pixel_m) {
  const DensityImage image(places, pixel_m);
  if (image.pixels.empty()) return {};
  const DensityImage smooth = image.smoothed();
  std::vector<DensityFeature> all, telling;
  for (const Corner& corner : corners_of(image)) all.push_back(described(image, smooth, corner));
  for (const DensityFeature& one : all) {
    int least = 256;
    for (const DensityFeature& other : all) {
      if (&one != &other) least = std::min(least, bits_apart(one, other));
    }
    if (least > kAlike) telling.push_back(one);
  }
  return telling;
}

std::uint32_t agreeing_features(const std::vector<DensityFeature>& known,
                                const std::vector<DensityFeature>& asked) {
  std::vector<Match> matches;
  for (const DensityFeature& one : asked) {
    const DensityFeature* nearest = nullptr;
    int least = kNear + 1;
    for (const DensityFeature& other : known) {
      const int apart = bits_apart(one, other);
      if (apart >= least) continue;
      least = apart;
      nearest = &other;
    }
    if (nearest != nullptr) matches.push_back({nearest, &one});
  }
  if (matches.size() <= 2) return 0;
  testing::Draws draws(matches.size());
  const double n = static_cast<double>(matches.size());
  std::uint32_t best = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto i = static_cast<std::size_t>(draws.uniform(0, n)),
               k = static_cast<std::size_t>(draws.uniform(0, n));
    if (i != k) best = std::max(best, agreeing(matches, matches[i], matches[k]));
  }
  return best;
}

}  // namespace sortie::bench
