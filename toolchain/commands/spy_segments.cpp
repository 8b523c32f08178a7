// SPDX-License-Identifier: BSD-3-Clause
// A list of segments.
#include <string>

#include "drivers/wire_segments.hpp"
#include "toolchain/commands/spy_values.hpp"

namespace sortie::toolchain {

Status read_segments(std::span<const std::uint8_t> message, std::vector<drivers::NamedValue>& values) {
  const auto add = [&values](std::string name, auto number) {
    values.push_back({std::move(name), static_cast<double>(number)});
  };
  rt::SegmentList list;
  std::int64_t seq = 0;
  const Status status = drivers::decode(message, list, seq);
  if (status != Status::ok) return status;
  add("seq", seq);
  add("stamp_ns", list.stamp_ns);
  add("segments", list.segments);
  std::uint32_t changes[4]{};
  for (const rt::SegmentEvent& event : std::span(list.event, list.listed_events)) {
    const bool cut = event.change == rt::SegmentChange::born && event.other != 0;
    ++changes[cut ? 3 : static_cast<int>(event.change)];
  }
  add("born", changes[static_cast<int>(rt::SegmentChange::born)]);
  add("cut", changes[3]);
  add("renamed", changes[static_cast<int>(rt::SegmentChange::renamed)]);
  add("gone", changes[static_cast<int>(rt::SegmentChange::gone)]);
  for (const rt::ListedSegment& segment : std::span(list.segment, list.listed)) {
    const std::string name = "segment " + std::to_string(segment.id) + " ";
    add(name + "voxels", segment.voxels);
    if (!list.features) continue;
    const char* const axes[] = {"x_m", "y_m", "z_m"};
    for (int i = 0; i < 3; ++i)
      add(name + axes[i], list.origin_m[i] + static_cast<double>(segment.centroid_m[i]));
    add(name + "linearity", segment.feature[0]);
    add(name + "planarity", segment.feature[1]);
    add(name + "scattering", segment.feature[2]);
  }
  return status;
}

}  // namespace sortie::toolchain
