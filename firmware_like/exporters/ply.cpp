// SPDX-License-Identifier: BSD-3-Clause
// PLY 1.0 with one element.
#include "firmware_like/exporters/ply.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <ostream>
#include <string>

#include "firmware_like/text_format.hpp"

namespace sortie::firmware {
namespace {

static_assert(std::endian::native == std::endian::little && sizeof(CloudPoint) == 16,
              "points are written as they lie");

bool finite(const CloudPoint& p) {
  return std::isfinite(p.x_m) && std::isfinite(p.y_m) && std::isfinite(p.z_m);
}

}  // namespace

std::size_t write_ply(std::ostream& out, std::span<const CloudPoint> points, PlyFormat format) {
  const auto count = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), finite));
  out << "ply\nformat " << (format == PlyFormat::binary ? "binary_little_endian" : "ascii")
      << " 1.0\ncomment metres, world frame\nelement vertex " << std::to_string(count)
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty uint hits\nend_header\n";
  for (const CloudPoint& point : points) {
    if (!finite(point)) continue;
    if (format == PlyFormat::binary) {
      char bytes[sizeof point];
      std::memcpy(bytes, &point, sizeof point);
      out.write(bytes, sizeof bytes);
    } else {
      out << format_exact(point.x_m) << ' ' << format_exact(point.y_m) << ' ' << format_exact(point.z_m)
          << ' ' << std::to_string(point.hits) << '\n';
    }
  }
  return count;
}

}  // namespace sortie::firmware
