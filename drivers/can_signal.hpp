// SPDX-License-Identifier: BSD-3-Clause
// Messages and signals of a CAN database as constant tables, and how their values stand in a frame.
// toolchain/dbc-table makes such tables from .dbc files at build.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// What a signal's bits are.
enum class CanValue : std::uint8_t { whole, signed_whole, float32, float64 };

/// One signal of a message: physical value = raw * scale + offset.
struct CanSignal {
  const char* name;
  std::uint8_t
      shift;  ///< above the lowest bit of the 8 data bytes, read as one number in the signal's byte order
  std::uint8_t length;  ///< bits, 1 to 64
  bool big_endian;      ///< Motorola; else Intel
  CanValue value;
  double scale;
  double offset;
  double low;   ///< physical; low == high: not said
  double high;  ///< physical
  const char* unit;
  const char* meaning;
  std::int16_t mux;  ///< there only when the multiplexer has this raw value; -1: always
};

/// One message.
struct CanMessage {
  const char* name;
  std::uint32_t id;
  bool extended;  ///< identifier of 29 bits
  std::uint8_t size;
  const CanSignal* fields;
  std::size_t field_count;
  const char* meaning;
  std::int16_t mux;  ///< number of the signal that is the multiplexer; -1: none

  constexpr bool is(const CanFrame& frame) const {
    return frame.id == id && frame.size == size && (frame.flags & ~kCanExtended) == 0 &&
           ((frame.flags & kCanExtended) != 0) == extended;
  }
};

namespace detail {

constexpr std::uint64_t mask_of(unsigned bits) {
  return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
}

constexpr std::uint64_t word_of(const CanFrame& frame, bool big_endian) {
  std::uint64_t word = 0;
  for (unsigned i = 0; i < 8; ++i) word |= std::uint64_t{frame.data[i]} << 8u * (big_endian ? 7u - i : i);
  return word;
}

}  // namespace detail

/// Raw value of a signal, with its sign where it has one; the bits of a float as they are. Reads the frame's
/// eight bytes, used or not: any signal of a table that dbc-table made is safe. A few instructions.
constexpr std::int64_t read_can_field(const CanFrame& frame, const CanSignal& signal) {
  std::uint64_t raw =
      detail::word_of(frame, signal.big_endian) >> signal.shift & detail::mask_of(signal.length);
  const std::uint64_t sign = std::uint64_t{1} << (signal.length - 1u);
  if (signal.value == CanValue::signed_whole && (raw & sign) != 0) raw |= ~(sign | (sign - 1));
  return static_cast<std::int64_t>(raw);
}

/// Writes the low bits of `raw` into a signal (a wrapping counter wraps here); the frame's other bits stay.
constexpr void write_can_field(CanFrame& frame, const CanSignal& signal, std::int64_t raw) {
  const std::uint64_t mask = detail::mask_of(signal.length) << signal.shift;
  std::uint64_t word = detail::word_of(frame, signal.big_endian);
  word = (word & ~mask) | (static_cast<std::uint64_t>(raw) << signal.shift & mask);
  for (unsigned i = 0; i < 8; ++i)
    frame.data[i] = static_cast<std::uint8_t>(word >> 8u * (signal.big_endian ? 7u - i : i) & 0xFFu);
}

/// Whether a multiplexed signal is in this frame. `message` holds `signal`.
constexpr bool has_can_field(const CanFrame& frame, const CanMessage& message, const CanSignal& signal) {
  return signal.mux < 0 || read_can_field(frame, message.fields[message.mux]) == signal.mux;
}

/// Physical value of a signal. A float may be not finite.
inline double physical_can_field(const CanFrame& frame, const CanSignal& signal) {
  const std::int64_t raw = read_can_field(frame, signal);
  double value = static_cast<double>(raw);
  if (signal.value == CanValue::whole) value = static_cast<double>(static_cast<std::uint64_t>(raw));
  if (signal.value == CanValue::float32)
    value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
  if (signal.value == CanValue::float64) value = std::bit_cast<double>(raw);
  return value * signal.scale + signal.offset;
}

/// Writes the nearest value that the signal can hold. Status: ok; not_finite, out_of_range (of its range, or
/// of its bits): the frame is unchanged.
[[nodiscard]] inline Status set_can_field(CanFrame& frame, const CanSignal& signal, double physical) {
  if (!std::isfinite(physical)) return Status::not_finite;
  if (signal.low < signal.high && !(physical >= signal.low && physical <= signal.high))
    return Status::out_of_range;
  const double value = (physical - signal.offset) / signal.scale;
  if (signal.value == CanValue::float64) {
    write_can_field(frame, signal, std::bit_cast<std::int64_t>(value));
    return Status::ok;
  }
  if (signal.value == CanValue::float32) {
    if (!(std::fabs(value) <= 3.4028234663852886e38)) return Status::out_of_range;
    write_can_field(frame, signal, std::bit_cast<std::int32_t>(static_cast<float>(value)));
    return Status::ok;
  }
  const bool is_signed = signal.value == CanValue::signed_whole;
  const double top = std::ldexp(1.0, signal.length - (is_signed ? 1 : 0));  // the first that does not fit
  const double raw = std::floor(value + 0.5);
  if (!(raw < top) || !(raw >= (is_signed ? -top : 0.0))) return Status::out_of_range;
  write_can_field(frame, signal,
                  is_signed ? static_cast<std::int64_t>(raw)
                            : static_cast<std::int64_t>(static_cast<std::uint64_t>(raw)));
  return Status::ok;
}

}  // namespace sortie::drivers
