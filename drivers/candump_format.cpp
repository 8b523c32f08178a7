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

bool is_interface(std::string_view interface) {
  return !interface.empty() && interface.size() <= 15 &&
         std::all_of(interface.begin(), interface.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

bool writable(const CanFrame& frame) {
  if (frame.stamp_ns < 0 || frame.size > 8) return false;
  if ((frame.flags & kCanError) != 0) return frame.flags == kCanError && frame.id <= kIdMask;
  if ((frame.flags & ~(kCanExtended | kCanRemote)) != 0) return false;
  return frame.id <= ((frame.flags & kCanExtended) != 0 ? kIdMask : 0x7FFu);
}

// Time, interface and identifier.
template <class Frame>
void put_head(Sink& line, const Frame& frame, std::string_view interface, CandumpDigits digits) {
  const rt::Nanoseconds part = frame.stamp_ns % rt::kNanosecondsPerSecond;
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
    line.hex(frame.id | ((frame.flags & kCanError) != 0 ? kErrorBit : 0u), 8);
  }
  line.put('#');
}

}  // namespace

std::size_t format_candump_line(const CanFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept {
  if (!is_interface(interface) || !writable(frame)) return 0;
  Sink line(out);
  put_head(line, frame, interface, digits);
  if ((frame.flags & kCanRemote) != 0) {
    line.put('R');
    if (frame.size != 0) line.put(static_cast<char>('0' + frame.size));
  } else {
    for (std::size_t i = 0; i < frame.size; ++i) line.hex(frame.data[i], 2);
  }
  return line.length();
}

std::size_t format_candump_line(const CanFdFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept {
  CanFrame classical;
  if (narrowed(frame, classical) == Status::ok) return format_candump_line(classical, interface, digits, out);
  if (!is_interface(interface) || frame.stamp_ns < 0 || !can_fd_frame_valid(frame)) return 0;
  Sink line(out);
  put_head(line, frame, interface, digits);
  line.put('#');
  line.hex(
      ((frame.flags & kCanBitRateSwitch) != 0 ? 1u : 0u) | ((frame.flags & kCanErrorState) != 0 ? 2u : 0u),
      1);
  for (std::size_t i = 0; i < frame.size; ++i) line.hex(frame.data[i], 2);
  return line.length();
}

}  // namespace sortie::drivers
