// SPDX-License-Identifier: BSD-3-Clause
// candump log files: the file around the lines, and a line as it is written.
#include "drivers/candump.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kErrorFrameBit = 0x20000000;

std::string system_text(int error) { return std::generic_category().message(error); }

/// Fills a span from the front; too small a span ends in length 0.
class Sink {
 public:
  explicit Sink(std::span<char> out) : out_(out) {}
  void put(char c) {
    if (used_ < out_.size()) out_[used_] = c;
    ++used_;
  }
  void put(std::string_view text) {
    for (const char c : text) put(c);
  }
  void decimal(std::int64_t value, int digits) {
    std::array<char, 20> text{};
    for (int i = digits - 1; i >= 0; --i, value /= 10) {
      text[static_cast<std::size_t>(i)] = static_cast<char>('0' + value % 10);
    }
    put(std::string_view(text.data(), static_cast<std::size_t>(digits)));
  }
  void hex(std::uint32_t value, int digits) {
    for (int i = digits - 1; i >= 0; --i) put("0123456789ABCDEF"[(value >> (4 * i)) & 0xFu]);
  }
  std::size_t length() const { return used_ <= out_.size() ? used_ : 0; }

 private:
  std::span<char> out_;
  std::size_t used_{0};
};

bool is_interface(std::string_view interface) {
  return !interface.empty() && interface.size() <= 15 &&
         std::all_of(interface.begin(), interface.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

bool writable(const CanFdFrame& frame) {
  if (frame.stamp_ns < 0) return false;
  if (frame.flags != kCanError) return can_fd_frame_valid(frame);
  return frame.size <= 8 && frame.id <= 0x1FFFFFFF;
}

}  // namespace

std::size_t format_candump_line(const CanFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept {
  // Other bits would make it a frame of another kind.
  if ((frame.flags & ~(kCanExtended | kCanRemote | kCanError)) != 0) return 0;
  return format_candump_line(widened(frame), interface, digits, out);
}

std::size_t format_candump_line(const CanFdFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept {
  if (!is_interface(interface) || !writable(frame)) return 0;
  const rt::Nanoseconds part = frame.stamp_ns % rt::kNanosecondsPerSecond;
  Sink line(out);
  line.put('(');
  line.decimal(frame.stamp_ns / rt::kNanosecondsPerSecond, 10);
  line.put('.');
  line.decimal(digits == CandumpDigits::nano ? part : part / 1000, static_cast<int>(digits));
  line.put(") ");
  line.put(interface);
  line.put(' ');
  if ((frame.flags & (kCanExtended | kCanError)) == 0) {
    line.hex(frame.id, 3);
  } else {
    line.hex(frame.id | ((frame.flags & kCanError) != 0 ? kErrorFrameBit : 0u), 8);
  }
  line.put('#');
  if ((frame.flags & kCanFd) != 0) {
    line.put('#');
    line.hex(
        ((frame.flags & kCanBitRateSwitch) != 0 ? 1u : 0u) | ((frame.flags & kCanErrorState) != 0 ? 2u : 0u),
        1);
  }
  if ((frame.flags & kCanRemote) != 0) {
    line.put('R');
    if (frame.size != 0) line.put(static_cast<char>('0' + frame.size));
  } else {
    for (std::size_t i = 0; i < frame.size; ++i) line.hex(frame.data[i], 2);
  }
  return line.length();
}

CandumpReader::CandumpReader(const std::string& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw std::runtime_error(path + ": is a folder; give the candump log in it");
  }
  errno = 0;
  file_.open(path, std::ios::in | std::ios::binary);
  if (!file_) {
    throw std::runtime_error(path + ": cannot be opened (" + system_text(errno) +
                             "); check the path, or record one with candump -l can0");
  }
}

Status CandumpReader::fail(const CandumpFault& fault) {
  ++problems_;
  problem_ = path_ + ", line " + std::to_string(line_) + ": " + fault.reason + "; " + fault.cure;
  return Status::malformed;
}

Status CandumpReader::next(CandumpRecord& record) { return next_of(record); }
Status CandumpReader::next(CandumpFdRecord& record) { return next_of(record); }

template <class Record>
Status CandumpReader::next_of(Record& record) {
  char text[kCandumpFdMaxLine + 2];
  for (;;) {
    file_.getline(text, sizeof text);
    const auto taken = static_cast<std::size_t>(file_.gcount());
    if (file_.bad()) {
      ++line_;
      return fail({"the file could not be read on", "check the disk; all lines before this one were read"});
    }
    if (taken == 0) return Status::empty;
    ++line_;
    if (file_.eof()) {
      return fail(
          {"the last line has no line end", "it may have been cut off; if it is whole, end it with Enter"});
    }
    if (file_.fail()) {  // the line is longer than the buffer
      file_.clear();
      file_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      return fail(
          {"the line is longer than 191 characters", "is this a candump log? they are made by candump -l"});
    }
    const std::string_view line(text, taken - 1);
    if (line.empty() || line == "\r") continue;
    CandumpFault fault;
    if (parse_candump_line(line, record, fault) != Status::ok) return fail(fault);
    ++frames_;
    return Status::ok;
  }
}

CandumpWriter::CandumpWriter(const std::string& path, CandumpDigits digits) : digits_(digits) {
  errno = 0;
  file_.open(path, std::ios::out | std::ios::binary | std::ios::trunc);
  if (!file_) {
    throw std::runtime_error(path + ": cannot be written (" + system_text(errno) +
                             "); check that the folder exists and is yours");
  }
}

Status CandumpWriter::write(const CanFrame& frame, std::string_view interface) {
  return write(widened(frame), interface);
}

Status CandumpWriter::write(const CanFdFrame& frame, std::string_view interface) {
  char text[kCandumpFdMaxLine + 1];
  const std::size_t length =
      format_candump_line(frame, interface, digits_, std::span<char>(text, kCandumpFdMaxLine));
  if (length == 0) return Status::malformed;
  text[length] = '\n';
  if (!file_.write(text, static_cast<std::streamsize>(length + 1))) return Status::full;
  ++frames_;
  return Status::ok;
}

Status CandumpWriter::close() {
  if (!file_.is_open()) return Status::ok;
  file_.close();
  return file_ ? Status::ok : Status::full;
}

}  // namespace sortie::drivers
