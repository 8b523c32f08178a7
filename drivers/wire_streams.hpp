// SPDX-License-Identifier: BSD-3-Clause
// What a walk over the members of a message (wire_walk.hpp) does with them: writes, reads, or counts bytes.
// Internal to the codecs.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "drivers/wire_cursor.hpp"
#include "rt/status.hpp"

namespace sortie::drivers::detail {

/// Counts the bytes of a value; `fixed`: all values of its type have as many.
struct WireSize {
  static constexpr bool kReads = false;
  static constexpr bool kLooksInside = true;
  std::size_t bytes{};
  bool fixed{true};

  template <class V>
  constexpr void numbers(const V*, std::size_t count) noexcept {
    bytes += count * sizeof(V);
  }
  constexpr void text(std::string_view value) noexcept {
    bytes += WireReader::kMinStringBytes + value.size();
    fixed = false;
  }
  constexpr void resize(const auto&, std::size_t) noexcept {
    bytes += sizeof(std::int32_t);
    fixed = false;
  }
  constexpr auto bounded(const auto& rows, std::size_t) noexcept {
    fixed = false;
    return rows.room.first(rows.count);
  }
};
/// The same with all texts and lists taken as empty.
struct WireLeast : WireSize {
  static constexpr bool kLooksInside = false;
};

/// Numbers alone, where the bytes are known to be there: reads where they are const, writes elsewhere.
template <class Byte>
struct WireBlock {
  static constexpr bool kReads = std::is_const_v<Byte>;
  static constexpr bool kLooksInside = true;
  Byte* at;

  template <class V>
  void numbers(V* values, std::size_t count) noexcept {
    if constexpr (kReads) {
      load_values(at, values, count);
    } else {
      store_values(at, values, count);
    }
    at += count * sizeof(V);
  }
};

/// Writes.
struct WireOut {
  static constexpr bool kReads = false;
  static constexpr bool kLooksInside = true;
  WireWriter writer;

  template <class V>
  void numbers(const V* values, std::size_t count) noexcept {
    writer.put_array(values, count);
  }
  void text(std::string_view value) noexcept { writer.put_string(value); }
  void resize(const auto& list, std::size_t) noexcept { writer.put_count(list.size()); }
  auto bounded(const auto& rows, std::size_t least) noexcept {
    const bool fits = rows.count <= rows.room.size() && writer.room_for(rows.count, least);
    if (!fits) writer.refuse();
    return rows.room.first(fits ? rows.count : 0);
  }
  WireBlock<std::uint8_t> block(std::size_t count, std::size_t bytes) noexcept {
    return {writer.put_block(count, bytes)};
  }
};

/// Reads. No count is believed before the bytes that it needs are known to be there.
struct WireIn {
  static constexpr bool kReads = true;
  static constexpr bool kLooksInside = true;
  WireReader reader;
  bool full{};  ///< there were rows without room, which were passed over

  template <class V>
  void numbers(V* values, std::size_t count) noexcept {
    reader.get_array(values, count);
  }
  void numbers(const std::uint8_t*, std::size_t) noexcept {}  // a view of bytes is its own reading
  void text(auto& value) { value = reader.get_string(); }
  template <std::size_t N>
  void text(char (&value)[N]) noexcept {
    const std::string_view found = reader.get_string();
    if (found.size() >= N) return reader.refuse();
    for (std::size_t i = 0; i < N; ++i) value[i] = i < found.size() ? found[i] : '\0';
  }
  template <class List>
  void resize(List& list, std::size_t least) {
    const std::size_t count = reader.get_count(least);
    if constexpr (std::is_same_v<List, std::span<const std::uint8_t>>) {
      list = reader.get_bytes(count);
    } else if constexpr (requires { List::capacity(); }) {  // a bounded one
      if (list.resize(static_cast<std::uint32_t>(count))) return;
      list.clear();
      pass_over(count * least);
    } else {
      list.resize(count);
    }
  }
  auto bounded(const auto& rows, std::size_t least) noexcept {
    const std::size_t count = rows.count;
    const bool there = count <= reader.left() / least;
    if (there && count <= rows.room.size()) return rows.room.first(count);
    rows.count = 0;
    if (there && rows.beyond == Status::full) {
      pass_over(count * least);
    } else {
      reader.refuse();
    }
    return rows.room.first(0);
  }
  WireBlock<const std::uint8_t> block(std::size_t count, std::size_t bytes) noexcept {
    if (count > reader.left() / bytes) reader.refuse();
    return {reader.status() == Status::ok ? reader.get_bytes(count * bytes).data() : nullptr};
  }

 private:
  void pass_over(std::size_t bytes) noexcept {
    full = true;
    static_cast<void>(reader.get_bytes(bytes));
  }
};

}  // namespace sortie::drivers::detail
