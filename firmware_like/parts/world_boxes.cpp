// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/world_boxes.hpp"

#include <algorithm>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {

namespace {
constexpr std::size_t kMostBoxes = 200;
}

std::vector<WorldBox> read_world_boxes(Profile& profile) {
  using Kind = ColumnSpec::Kind;
  const std::vector<ColumnSpec> columns = {
      {"x_m", Kind::number, {0, -1000, 1000, "m"}, true},
      {"y_m", Kind::number, {0, -1000, 1000, "m"}, true},
      {"z_m", Kind::number, {0, 0, 1000, "m"}},
      {"length_m", Kind::number, {0, 0.01, 1000, "m"}, true},
      {"width_m", Kind::number, {0, 0.01, 1000, "m"}, true},
      {"height_m", Kind::number, {3, 0.01, 1000, "m"}},
      {"from_s", Kind::number, {0, 0, 1e6, "s"}},
  };
  std::vector<WorldBox> boxes;
  for (const ProfileRow& row : profile.rows(
           "world.boxes", columns, kMostBoxes,
           "walls and pillars: lowest corner, extents along x, y, z, and from when on they stand there")) {
    WorldBox& box = boxes.emplace_back();
    const char* const corners[] = {"x_m", "y_m", "z_m"};
    const char* const extents[] = {"length_m", "width_m", "height_m"};
    for (int i = 0; i < 3; ++i) {
      box.lowest_m[i] = row.numbers.at(corners[i]);
      box.highest_m[i] = box.lowest_m[i] + row.numbers.at(extents[i]);
    }
    box.from_ns = milliseconds(1e3 * row.numbers.at("from_s"));
  }
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const WorldBox& a, const WorldBox& b) { return a.from_ns < b.from_ns; });
  return boxes;
}

}  // namespace sortie::firmware
