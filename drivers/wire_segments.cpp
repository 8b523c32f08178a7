// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_segments.hpp"

namespace sortie::drivers {

Status decode(std::span<const std::uint8_t> message, rt::SegmentList& list, std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintSegments); type != Status::ok) return type;
  static_cast<void>(reader.get_bytes(2 * 8 + 2 * 4 + 3 * 8));  // up to `n`
  const std::size_t count = reader.get_count(8);
  if (reader.status() != Status::ok) return Status::malformed;
  if (count > rt::SegmentList::kMost) return Status::full;
  std::fill_n(list.segment, count, rt::ListedSegment{});
  return detail::read_any(message, list, seq);
}

}  // namespace sortie::drivers
