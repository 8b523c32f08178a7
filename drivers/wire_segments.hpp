// SPDX-License-Identifier: BSD-3-Clause
// segments_t: the segments of a local map and their events. Codec as in wire.hpp.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/channels.hpp"
#include "rt/segment_list.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Bytes of a message with `segments` segments, of which `featured` have features, and `events` events.
constexpr std::size_t segments_bytes(std::size_t segments, std::size_t featured, std::size_t events) {
  return 8 + 2 * 8 + 2 * 4 + 3 * 8 + 3 * 4 + segments * 8 + featured * 64 + events * 9;
}
inline constexpr std::size_t kMaxSegmentsBytes =
    segments_bytes(rt::SegmentList::kMost, rt::SegmentList::kMost, rt::SegmentList::kMostEvents);
static_assert(kMaxSegmentsBytes < 16'384);

/// Status: ok, full (`out` is too small; `size` is then 0).
[[nodiscard]] Status encode(const rt::SegmentList& list, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// Status: ok; bad_checksum (another type); malformed (lengths, or a change that there is not); full (more
/// than fit). `list` is of no use unless ok.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SegmentList& list,
                            std::int64_t& seq) noexcept;

}  // namespace sortie::drivers
