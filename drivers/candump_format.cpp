// SPDX-License-Identifier: BSD-3-Clause
// One line of a candump log, written.
#include <algorithm>
#include <array>

#include "drivers/candump.hpp"

namespace sortie::drivers {

namespace {

constexpr std::uint32_t kErrorBit = 0x20000000;
constexpr std::uint32_t kIdMask = 0x1FFFFFFF;

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

bool writable(const CanFrame& frame, std::string_view interface) {
  if (interface.empty() || interface.size() > 15 || frame.stamp_ns < 0 || frame.size > 8) return false;
  if (!std::all_of(interface.begin(), interface.end(), [](char c) { return c > ' ' && c < '\x7f'; }))
    return false;
  if ((frame.flags & kCanError) != 0) return frame.flags == kCanError && frame.id <= kIdMask;
  if ((frame.flags & ~(kCanExtended | kCanRemote)) != 0) return false;
  return frame.id <= ((frame.flags & kCanExtended) != 0 ? kIdMask : 0x7FFu);
}

}  // namespace

std::size_t format_candump_line(const CanFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept {
  if (!writable(frame, interface)) return 0;
  Sink line(out);
  const rt::Nanoseconds part = frame.stamp_ns % rt::kNanosecondsPerSecond;
  line.put('(');
  line.decimal(frame.stamp_ns / rt::kNanosecondsPerSecond, 10);
  line.put('.');
  line.decimal(digits == CandumpDigits::nano ? part : part / 1000, static_cast<int>(digits));
  line.put(") ");
  line.put(interface);
  line.put(' ');
  if (frame.flags == 0 || frame.flags == kCanRemote) {
    line.hex(frame.id, 3);
  } else {
    line.hex(frame.id | ((frame.flags & kCanError) != 0 ? kErrorBit : 0u), 8);
  }
  line.put('#');
  if ((frame.flags & kCanRemote) != 0) {
    line.put('R');
    if (frame.size != 0) line.put(static_cast<char>('0' + frame.size));
  } else {
    for (std::size_t i = 0; i < frame.size; ++i) line.hex(frame.data[i], 2);
  }
  return line.length();
}

}  // namespace sortie::drivers
