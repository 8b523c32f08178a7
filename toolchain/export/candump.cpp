// SPDX-License-Identifier: BSD-3-Clause
// The line format is the drivers' own; here are only the stream and the counts.
#include "toolchain/export/candump.hpp"

#include <array>
#include <ostream>

#include "drivers/candump.hpp"

namespace sortie::toolchain {

CandumpCounts write_candump(std::ostream& out, std::span<const drivers::CanFrame> frames) {
  CandumpCounts counts;
  std::array<char, drivers::kCandumpMaxLine + 1> line{};
  for (const drivers::CanFrame& frame : frames) {
    const std::size_t length =
        drivers::format_candump_line(frame, "can0", drivers::CandumpDigits::micro, line);
    if (length == 0) {
      ++counts.refused;
      continue;
    }
    out.write(line.data(), static_cast<std::streamsize>(length));
    out << '\n';
    ++counts.frames;
  }
  return counts;
}

}  // namespace sortie::toolchain
