// SPDX-License-Identifier: BSD-3-Clause
// Bounded reading and writing of big-endian message bytes. Internal to the codecs: no length from the wire is
// ever trusted, nothing is allocated before the bytes that it stands for are known to be there.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "rt/status.hpp"

namespace sortie::drivers {

namespace detail {
template <std::size_t Bytes>
using UnsignedOf =
    std::conditional_t<Bytes == 1, std::uint8_t,
                       std::conditional_t<Bytes == 2, std::uint16_t,
                                          std::conditional_t<Bytes == 4, std::uint32_t, std::uint64_t>>>;

/// Host order to network order and back.
template <class Unsigned>
inline Unsigned swap_to_big_endian(Unsigned bits) noexcept {
  static_assert(std::endian::native == std::endian::little);
  if constexpr (sizeof(Unsigned) == 8) return static_cast<Unsigned>(__builtin_bswap64(bits));
  if constexpr (sizeof(Unsigned) == 4) return static_cast<Unsigned>(__builtin_bswap32(bits));
  if constexpr (sizeof(Unsigned) == 2) return static_cast<Unsigned>(__builtin_bswap16(bits));
  return bits;
}

/// `count` values to their bytes and back; whoever calls knows that the bytes are there.
template <class T>
inline void store_values(std::uint8_t* out, const T* values, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    const auto bits = swap_to_big_endian(std::bit_cast<UnsignedOf<sizeof(T)>>(values[i]));
    std::memcpy(out + i * sizeof(T), &bits, sizeof(T));
  }
}
template <class T>
inline void load_values(const std::uint8_t* in, T* values, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    UnsignedOf<sizeof(T)> bits{};
    std::memcpy(&bits, in + i * sizeof(T), sizeof(T));
    values[i] = std::bit_cast<T>(swap_to_big_endian(bits));
  }
}
inline void store_values(std::uint8_t* out, const std::uint8_t* values, std::size_t count) noexcept {
  if (count != 0) std::memcpy(out, values, count);
}
inline void load_values(const std::uint8_t* in, std::uint8_t* values, std::size_t count) noexcept {
  if (count != 0) std::memcpy(values, in, count);
}
}  // namespace detail

/// Writes scalars, arrays and strings one after the other. After the first lack of room every further call is
/// a no-op and status() is `full`. Never writes outside the span.
class WireWriter {
 public:
  explicit WireWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}

  template <class T>
  void put(T value) noexcept {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    put_array(&value, 1);
  }
  template <class T>
  void put_array(const T* values, std::size_t count) noexcept {
    if (!room_for(count, sizeof(T))) return;
    detail::store_values(out_.data() + used_, values, count);
    used_ += count * sizeof(T);
  }
  /// LCM string: length with the final zero as int32, bytes, zero.
  void put_string(std::string_view text) noexcept {
    if (text.size() > kMaxString) return refuse();
    put(static_cast<std::int32_t>(text.size() + 1));
    put_array(text.data(), text.size());
    put(std::uint8_t{0});
  }
  /// Number of elements that follow, as LCM counts them: int32. More than that holds is `full`.
  void put_count(std::size_t count) noexcept {
    if (count > kMaxCount) return refuse();
    put(static_cast<std::int32_t>(count));
  }
  /// Whether that many elements of at least `bytes` each can follow; if not, nothing more will.
  [[nodiscard]] bool room_for(std::size_t count, std::size_t bytes) noexcept {
    if (count > kMaxCount || count > (out_.size() - used_) / bytes) full_ = true;
    return !full_;
  }
  /// The next `count` times `bytes` bytes, for the caller to write; null if there is no room for them.
  [[nodiscard]] std::uint8_t* put_block(std::size_t count, std::size_t bytes) noexcept {
    if (!room_for(count, bytes)) return nullptr;
    used_ += count * bytes;
    return out_.data() + used_ - count * bytes;
  }
  /// Gives up: the message cannot be written.
  void refuse() noexcept { full_ = true; }
  /// Ends the message: `size` becomes its size, or 0 when it did not fit. Same result as status().
  [[nodiscard]] Status finish(std::size_t& size) const noexcept {
    size = full_ ? 0 : used_;
    return status();
  }
  [[nodiscard]] std::size_t size() const noexcept { return used_; }
  [[nodiscard]] Status status() const noexcept { return full_ ? Status::full : Status::ok; }

 private:
  static constexpr std::size_t kMaxString = 1u << 28;
  static constexpr std::size_t kMaxCount = 0x7fffffff;
  std::span<std::uint8_t> out_;
  std::size_t used_{};
  bool full_{};
};

/// Reads the same way. After the first lack of bytes or absurd length every further call gives zeros and
/// status() is `malformed`.
class WireReader {
 public:
  /// The least that a string takes: its length and the final zero.
  static constexpr std::size_t kMinStringBytes = 5;

  explicit WireReader(std::span<const std::uint8_t> in) noexcept : in_(in) {}

  template <class T>
  [[nodiscard]] T get() noexcept {
    T value{};
    get_array(&value, 1);
    return value;
  }
  template <class T>
  void get_array(T* values, std::size_t count) noexcept {
    if (!available<T>(count)) return;
    detail::load_values(in_.data() + used_, values, count);
    used_ += count * sizeof(T);
  }
  /// A count of elements of at least `element_bytes` each: negative or more than the bytes left is malformed
  /// and gives 0, so that a caller may size its memory by the result.
  [[nodiscard]] std::size_t get_count(std::size_t element_bytes) noexcept {
    const auto count = get<std::int32_t>();
    if (bad_ || count < 0 || static_cast<std::size_t>(count) > left() / element_bytes) {
      bad_ = true;
      return 0;
    }
    return static_cast<std::size_t>(count);
  }
  /// View of the next `count` raw bytes.
  [[nodiscard]] std::span<const std::uint8_t> get_bytes(std::size_t count) noexcept {
    if (!available<std::uint8_t>(count)) return {};
    const auto bytes = in_.subspan(used_, count);
    used_ += count;
    return bytes;
  }
  /// View of an LCM string without its final zero. Length 0, no final zero and inner zeros are malformed.
  [[nodiscard]] std::string_view get_string() noexcept {
    const std::size_t length = get_count(1);
    const auto bytes = get_bytes(length);
    if (bad_ || length == 0 || std::memchr(bytes.data(), 0, length) != bytes.data() + length - 1) {
      bad_ = true;
      return {};
    }
    return {reinterpret_cast<const char*>(bytes.data()), length - 1};
  }
  /// What was read cannot be: from here on as after a lack of bytes.
  void refuse() noexcept { bad_ = true; }
  [[nodiscard]] std::size_t left() const noexcept { return in_.size() - used_; }
  /// `malformed` after any failed read.
  [[nodiscard]] Status status() const noexcept { return bad_ ? Status::malformed : Status::ok; }
  /// As status(), and bytes left over are malformed, too.
  [[nodiscard]] Status finish() const noexcept {
    return bad_ || left() != 0 ? Status::malformed : Status::ok;
  }

 private:
  template <class T>
  bool available(std::size_t count) noexcept {
    if (count > left() / sizeof(T)) bad_ = true;
    return !bad_;
  }
  std::span<const std::uint8_t> in_;
  std::size_t used_{};
  bool bad_{};
};

/// The type of a message: its first eight bytes; 0 if there are fewer.
inline std::uint64_t fingerprint_of(std::span<const std::uint8_t> message) noexcept {
  return WireReader(message).get<std::uint64_t>();
}

/// Reads the fingerprint. `bad_checksum`: a message of another type; `malformed`: fewer than eight bytes.
inline Status expect_fingerprint(WireReader& reader, std::uint64_t expected) noexcept {
  const auto found = reader.get<std::uint64_t>();
  if (reader.status() != Status::ok) return Status::malformed;
  return found == expected ? Status::ok : Status::bad_checksum;
}

}  // namespace sortie::drivers
