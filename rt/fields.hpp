// SPDX-License-Identifier: BSD-3-Clause
// One list of fields a struct: digests, field checks, CSV, JSON and telemetry are all derived from it.
//
// A struct lists its fields once:
//
//   struct Sample {
//     std::int64_t stamp_ns{};
//     double speed_m_s[2]{};
//     template <class Self, class Visitor>
//     static constexpr void fields(Self& self, Visitor&& visit) {
//       visit("stamp_ns", self.stamp_ns);
//       visit("speed_m_s", self.speed_m_s);
//     }
//   };
//
// Allowed field types: arithmetic types, enums, C arrays of them, and structs that list their own fields.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sortie::rt {

namespace detail {
struct NullVisitor {
  template <class T>
  constexpr void operator()(const char*, T&) const {}
};
}  // namespace detail

/// A type that lists its fields.
template <class T>
concept Described = requires(T& value) {
  T::fields(value, detail::NullVisitor{});
};

/// Bytes of the canonical form of T: every field in order, little endian, no padding; at compile time.
template <class T>
constexpr std::size_t canonical_size() {
  if constexpr (std::is_array_v<T>) {
    return std::extent_v<T> * canonical_size<std::remove_extent_t<T>>();
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    return sizeof(T);
  } else {
    static_assert(Described<T>, "a field must be arithmetic, an enum, a C array, or list its own fields");
    std::size_t bytes = 0;
    const T value{};
    T::fields(value, [&bytes](const char*, const auto& field) {
      bytes += canonical_size<std::remove_cvref_t<decltype(field)>>();
    });
    return bytes;
  }
}

namespace detail {
static_assert(std::endian::native == std::endian::little, "the canonical form is little endian");

template <class T>
inline std::uint8_t* encode_one(std::uint8_t* out, const T& value) {
  if constexpr (std::is_array_v<T>) {
    for (const auto& element : value) out = encode_one(out, element);
    return out;
  } else if constexpr (std::is_same_v<T, bool>) {
    *out = value ? 1 : 0;
    return out + 1;
  } else if constexpr (std::is_floating_point_v<T>) {
    // All NaNs are one NaN: their bit pattern differs between processors.
    const T canonical =
        std::isnan(value) ? std::bit_cast<T>(std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>(
                                sizeof(T) == 4 ? 0x7fc00000u : 0x7ff8000000000000u))
                          : value;
    std::memcpy(out, &canonical, sizeof(T));
    return out + sizeof(T);
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    std::memcpy(out, &value, sizeof(T));
    return out + sizeof(T);
  } else {
    T::fields(value, [&out](const char*, const auto& field) { out = encode_one(out, field); });
    return out;
  }
}
}  // namespace detail

/// Writes the canonical form of `value` to `out` (room for canonical_size<T>() bytes). Returns the bytes
/// written. No heap, no padding is read, every NaN is written as the same NaN. Cost: about one store a field.
template <class T>
inline std::size_t encode_canonical(const T& value, std::uint8_t* out) {
  return static_cast<std::size_t>(detail::encode_one(out, value) - out);
}

namespace detail {
template <class T>
inline const std::uint8_t* decode_one(const std::uint8_t* in, T& value) {
  if constexpr (std::is_array_v<T>) {
    for (auto& element : value) in = decode_one(in, element);
    return in;
  } else if constexpr (std::is_same_v<T, bool>) {
    value = *in != 0;
    return in + 1;
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    std::memcpy(&value, in, sizeof(T));
    return in + sizeof(T);
  } else {
    T::fields(value, [&in](const char*, auto& field) { in = decode_one(in, field); });
    return in;
  }
}
}  // namespace detail

/// Reads a value back from its canonical form of canonical_size<T>() bytes.
template <class T>
inline void decode_canonical(const std::uint8_t* in, T& value) {
  detail::decode_one(in, value);
}

/// Adds each field of `more` to the same field of `to`, in structs of nothing but 64-bit counters.
template <Described T>
constexpr void add_fields(const T& more, T& to) {
  std::uint64_t values[canonical_size<T>() / sizeof(std::uint64_t)]{};
  std::uint64_t* next = values;
  T::fields(more, [&next](const char*, const std::uint64_t& field) { *next++ = field; });
  next = values;
  T::fields(to, [&next](const char*, std::uint64_t& field) { field += *next++; });
}

/// Calls `leaf(name, index, scalar)` for every scalar of `value`; `index` is -1 outside arrays. Nested
/// structs are walked with their own field names. For tables, CSV and telemetry; not for the real-time path.
template <class T, class Leaf>
inline void for_each_scalar(const T& value, Leaf&& leaf) {
  T::fields(value, [&leaf](const char* name, const auto& field) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (std::is_array_v<Field>) {
      int index = 0;
      for (const auto& element : field) {
        if constexpr (std::is_arithmetic_v<std::remove_extent_t<Field>>) {
          leaf(name, index, element);
        } else {
          for_each_scalar(element, leaf);
        }
        ++index;
      }
    } else if constexpr (std::is_arithmetic_v<Field>) {
      leaf(name, -1, field);
    } else if constexpr (std::is_enum_v<Field>) {
      leaf(name, -1, static_cast<std::underlying_type_t<Field>>(field));
    } else {
      for_each_scalar(field, leaf);
    }
  });
}

}  // namespace sortie::rt
