// SPDX-License-Identifier: BSD-3-Clause
// A local map's density seen from above, as an image.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/math.hpp"
#include "rt/rotation.hpp"

namespace sortie::bench {

/// Pixels of 0 to 255, row by row, within a black margin that is wide enough for whatever is looked at about
/// one of them.
struct DensityImage {
  static constexpr int kMargin = 24;

  int width{}, height{};  ///< with the margin
  int first_x{}, first_y{};
  std::vector<double> pixels;

  double at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  double& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }

  DensityImage() = default;
  DensityImage(const std::vector<rt::Vector3>& places, double pixel_m) {
    if (places.empty()) return;
    const auto pixel = [pixel_m](double v) { return static_cast<int>(std::floor(v / pixel_m)); };
    int last_x = pixel(places[0].x), last_y = pixel(places[0].y);
    first_x = last_x;
    first_y = last_y;
    for (const rt::Vector3& p : places) {
      first_x = std::min(first_x, pixel(p.x));
      first_y = std::min(first_y, pixel(p.y));
      last_x = std::max(last_x, pixel(p.x));
      last_y = std::max(last_y, pixel(p.y));
    }
    first_x -= kMargin;
    first_y -= kMargin;
    width = last_x - first_x + 1 + kMargin;
    height = last_y - first_y + 1 + kMargin;
    pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0);
    for (const rt::Vector3& p : places) at(pixel(p.x) - first_x, pixel(p.y) - first_y) += 1.0;
    scale();
  }

  /// Smoothed by a bell of 2 pixels, cut off at 7 by 7.
  DensityImage smoothed() const {
    double bell[4], sum = 0.0;
    for (int i = 0; i < 4; ++i) bell[i] = std::exp(-i * i / 8.0);
    for (int i = -3; i <= 3; ++i) sum += bell[std::abs(i)];
    DensityImage across = *this, out = *this;
    const auto pass = [&](const DensityImage& from, DensityImage& to, int dx, int dy) {
      for (int y = 3; y < height - 3; ++y) {
        for (int x = 3; x < width - 3; ++x) {
          double value = 0.0;
          for (int i = -3; i <= 3; ++i) value += bell[std::abs(i)] / sum * from.at(x + i * dx, y + i * dy);
          to.at(x, y) = value;
        }
      }
    };
    pass(*this, across, 1, 0);
    pass(across, out, 0, 1);
    for (double& value : out.pixels) value = std::round(value);
    return out;
  }

 private:
  /// From what the emptiest column that is not empty has to what the fullest has.
  void scale() {
    double least = 1e9, most = 0.0;
    for (const double count : pixels) {
      if (count > 0.0) least = std::min(least, count);
      most = std::max(most, count);
    }
    for (double& count : pixels) {
      const double density = most > least ? (count - least) / (most - least) : 0.0;
      count = density > 0.05 ? std::floor(255.0 * density) : 0.0;
    }
  }
};

}  // namespace sortie::bench
