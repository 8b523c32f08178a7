// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire.hpp"

namespace sortie::drivers {

Status decode(std::span<const std::uint8_t> message, rt::ScanHeader& header, std::span<rt::ScanPoint> points,
              std::int64_t& seq) noexcept {
  detail::WireIn stream{WireReader(message)};
  if (const Status type = expect_fingerprint(stream.reader, kFingerprintScan); type != Status::ok)
    return type;
  rt::ScanHeader read;
  std::int64_t number = 0;
  detail::walk_message(stream, read, number);
  const std::size_t left = stream.reader.left();
  if (stream.reader.status() != Status::ok || left % kScanPointBytes != 0 ||
      left / kScanPointBytes != read.points)
    return Status::malformed;
  header = read;
  seq = number;
  if (read.points > points.size()) return Status::full;
  detail::walk_elements<rt::ScanPoint, detail::AllMembers>(stream, points.first(read.points));
  return stream.reader.finish();
}

}  // namespace sortie::drivers
