// SPDX-License-Identifier: BSD-3-Clause
// One line of a candump log, read.
#include <algorithm>

#include "drivers/candump.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kErrorBit = 0x20000000;
constexpr std::uint32_t kIdMask = 0x1FFFFFFF;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes characters from the front of a line.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : text_(text) {}
  bool done() const { return text_.empty(); }
  char peek() const { return text_.empty() ? '\0' : text_.front(); }
  bool take(char c) {
    if (text_.empty() || text_.front() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  template <class Predicate>
  std::string_view take_while(Predicate&& wanted) {
    std::size_t n = 0;
    while (n < text_.size() && wanted(text_[n])) ++n;
    const std::string_view taken = text_.substr(0, n);
    text_.remove_prefix(n);
    return taken;
  }

 private:
  std::string_view text_;
};

std::int64_t decimal(std::string_view digits) {
  std::int64_t value = 0;
  for (const char c : digits) value = value * 10 + (c - '0');
  return value;
}

constexpr const char* kFormCure = "a line reads: (1408129200.042000) can0 123#0011AABB";

bool refuse(CandumpFault& fault, const char* reason, const char* cure) {
  fault = {reason, cure};
  return false;
}

bool parse_time(Cursor& line, rt::Nanoseconds& stamp_ns, CandumpFault& fault) {
  if (!line.take('(')) return refuse(fault, "the line does not begin with a time in parentheses", kFormCure);
  const std::string_view seconds = line.take_while(is_digit);
  const bool point = line.take('.');
  const std::string_view fraction = line.take_while(is_digit);
  if (seconds.empty() || !point || (fraction.size() != 6 && fraction.size() != 9) || !line.take(')'))
    return refuse(fault, "the time is not seconds with 6 or 9 decimals",
                  "record absolute or relative times with candump -L, or write (seconds.microseconds)");
  if (seconds.size() > 10 || decimal(seconds) > 9'223'372'035)
    return refuse(fault, "the time is beyond the year 2262",
                  "the seconds count from 1970 and have at most 10 digits");
  const std::int64_t part = fraction.size() == 6 ? decimal(fraction) * 1000 : decimal(fraction);
  stamp_ns = decimal(seconds) * rt::kNanosecondsPerSecond + part;
  return true;
}

bool parse_interface(Cursor& line, CandumpFdRecord& record, CandumpFault& fault) {
  static_cast<void>(line.take_while([](char c) { return c == ' '; }));
  const std::string_view name = line.take_while([](char c) { return c > ' ' && c < '\x7f'; });
  if (name.empty() || name.size() >= sizeof(record.interface) || !line.take(' '))
    return refuse(fault, "there is no interface name of 1 to 15 characters behind the time", kFormCure);
  std::copy(name.begin(), name.end(), record.interface);
  static_cast<void>(line.take_while([](char c) { return c == ' '; }));
  return true;
}

bool parse_id(Cursor& line, CanFdFrame& frame, CandumpFault& fault) {
  const std::string_view digits = line.take_while([](char c) { return hex_digit(c) >= 0; });
  if (digits.size() != 3 && digits.size() != 8)
    return refuse(fault, "the identifier does not have 3 or 8 hexadecimal digits",
                  "11-bit identifiers have 3 digits (07F), 29-bit ones 8 (0000007F)");
  std::uint32_t id = 0;
  for (const char c : digits) id = id << 4 | static_cast<std::uint32_t>(hex_digit(c));
  if (digits.size() == 3 && id > 0x7FF)
    return refuse(fault, "an identifier of 3 digits is above 7FF", "write a 29-bit identifier with 8 digits");
  if (id > (kIdMask | kErrorBit))
    return refuse(fault, "the identifier is above 1FFFFFFF",
                  "a 29-bit identifier begins with 0 or 1, an error frame with 2 or 3");
  if (digits.size() == 8) frame.flags = (id & kErrorBit) != 0 ? kCanError : kCanExtended;
  frame.id = id & kIdMask;
  return true;
}

bool parse_remote(Cursor& line, CanFdFrame& frame, CandumpFault& fault) {
  if ((frame.flags & kCanError) != 0)
    return refuse(fault, "an error frame cannot be a remote frame",
                  "clear bit 29 of the identifier or write its data");
  frame.flags = static_cast<std::uint8_t>(frame.flags | kCanRemote);
  if (!is_digit(line.peek())) return true;
  const std::string_view size = line.take_while(is_digit);
  if (size.size() == 1 && size[0] <= '8') {
    frame.size = static_cast<std::uint8_t>(size[0] - '0');
    return true;
  }
  return refuse(fault, "a remote frame asks for more than 8 bytes", "write R0 to R8, or R alone");
}

bool parse_data(Cursor& line, CanFdFrame& frame, std::size_t most, CandumpFault& fault) {
  const std::string_view digits = line.take_while([](char c) { return hex_digit(c) >= 0; });
  if (digits.size() % 2 != 0)
    return refuse(fault, "the data end in half a byte",
                  "every byte has two hexadecimal digits; the line may have been cut off");
  if (digits.size() > 2 * most)
    return refuse(fault, most == 8 ? "there are more than 8 data bytes" : "there are more than 64 data bytes",
                  "a classical frame has 8 at most, a CAN FD frame (##) 64; remove this line");
  frame.size = static_cast<std::uint8_t>(digits.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(hex_digit(digits[2 * i]) * 16 + hex_digit(digits[2 * i + 1]));
  }
  return true;
}

// What follows the second #.
bool parse_fd(Cursor& line, CanFdFrame& frame, CandumpFault& fault) {
  const int flags = hex_digit(line.peek());
  if ((frame.flags & kCanError) != 0 || flags < 0 || flags > 3)
    return refuse(fault, "a CAN FD frame has a digit of flags behind ##, 0 to 3, and is no error frame",
                  "it reads 123##1AABB: 1 for a bit rate switch, 2 for error state");
  static_cast<void>(line.take(line.peek()));
  if (!parse_data(line, frame, 64, fault)) return false;
  if (can_fd_size(frame.size) != frame.size)
    return refuse(fault, "no CAN FD frame has so many data bytes",
                  "it has 0 to 8, 12, 16, 20, 24, 32, 48 or 64; the line may have been cut off");
  const unsigned more = kCanFd | ((flags & 1) != 0 ? unsigned{kCanBitRateSwitch} : 0u) |
                        ((flags & 2) != 0 ? unsigned{kCanErrorState} : 0u);
  frame.flags = static_cast<std::uint8_t>(frame.flags | more);
  return true;
}

bool parse_frame(Cursor& line, bool fd, CanFdFrame& frame, CandumpFault& fault) {
  if (!parse_id(line, frame, fault)) return false;
  if (!line.take('#')) return refuse(fault, "there is no # behind the identifier", kFormCure);
  if (line.take('#')) {
    if (fd) return parse_fd(line, frame, fault);
    return refuse(fault, "this is a CAN FD frame (##), and only classical CAN is read",
                  "remove the FD frames: grep -v '##' OLD > NEW");
  }
  return line.take('R') ? parse_remote(line, frame, fault) : parse_data(line, frame, 8, fault);
}

bool parse_end(Cursor& line, CandumpFault& fault) {
  if (line.take(' ') && !line.take('R')) static_cast<void>(line.take('T'));
  static_cast<void>(line.take_while([](char c) { return c == ' ' || c == '\r'; }));
  if (line.done()) return true;
  return refuse(fault, "there are characters behind the frame that do not belong there", kFormCure);
}

// `record` may be half filled unless ok. `fd`: it may be an FD frame.
Status parse_line(std::string_view line, bool fd, CandumpFdRecord& record, CandumpFault& fault) {
  Cursor cursor(line);
  const bool good = parse_time(cursor, record.frame.stamp_ns, fault) &&
                    parse_interface(cursor, record, fault) && parse_frame(cursor, fd, record.frame, fault) &&
                    parse_end(cursor, fault);
  return good ? Status::ok : Status::malformed;
}

}  // namespace

Status parse_candump_line(std::string_view line, CandumpRecord& record, CandumpFault& fault) noexcept {
  CandumpFdRecord read;
  if (const Status status = parse_line(line, false, read, fault); status != Status::ok) return status;
  std::copy_n(read.interface, sizeof read.interface, record.interface);
  return narrowed(read.frame, record.frame);
}

Status parse_candump_line(std::string_view line, CandumpFdRecord& record, CandumpFault& fault) noexcept {
  CandumpFdRecord read;
  const Status status = parse_line(line, true, read, fault);
  if (status == Status::ok) record = read;
  return status;
}

}  // namespace sortie::drivers
