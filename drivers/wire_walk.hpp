// SPDX-License-Identifier: BSD-3-Clause
// The way through a message, part by part, that writing, reading and counting bytes have in common. Internal
// to the codecs.
#pragma once

#include <cstdint>
#include <iterator>
#include <string_view>
#include <type_traits>
#include <utility>

#include "drivers/wire_rules.hpp"
#include "drivers/wire_streams.hpp"

namespace sortie::drivers::detail {

/// A text, or letters up to the first zero.
constexpr std::string_view text_of(std::string_view text) noexcept { return text; }
template <std::size_t N>
constexpr std::string_view text_of(const char (&letters)[N]) noexcept {
  const std::string_view all(letters, N);
  return all.substr(0, all.find('\0'));
}

template <class Stream, class V>
constexpr void walk(Stream& stream, V& value);

template <class V, bool kEnum = std::is_enum_v<V>>
struct WireNumber : std::conditional<std::is_same_v<V, bool>, std::uint8_t, V> {};
template <class V>
struct WireNumber<V, true> : std::underlying_type<V> {};
template <class Stream, class V>
constexpr void walk_number(Stream& stream, V& value) {
  using Number = typename WireNumber<std::remove_const_t<V>>::type;  // as it travels
  Number number{};
  if constexpr (!Stream::kReads && Stream::kLooksInside) number = static_cast<Number>(value);
  stream.numbers(&number, 1);
  if constexpr (Stream::kReads) value = static_cast<V>(number);
}

/// Rows as columns: the first member of each of them, then the second, ...
template <class Members, std::size_t Column>
constexpr void walk_column(auto& stream, auto& rows) {
  for (auto& row : rows) {
    std::size_t at = 0;
    Members{}(row, [&](const char*, auto&& member) {
      if (at++ == Column) walk(stream, member);
    });
  }
}

template <class Row, class Members>
constexpr std::size_t columns_of() {
  std::size_t columns = 0;
  const auto count = [&columns](const char*, auto&& member) {
    using Member = std::remove_cvref_t<decltype(member)>;
    static_assert(wire_kind<Member>() < WireKind::list &&
                      wire_kind<std::remove_all_extents_t<Member>>() < WireKind::list,
                  "a row holds numbers, arrays of them and texts");
    ++columns;
  };
  show<Row>([&count](auto& row) { Members{}(row, count); });
  return columns;
}

/// What a value of T takes with all texts and lists empty.
template <class T, class Members = AllMembers>
constexpr WireSize least() {
  WireLeast size;
  show<T>([&size](auto& value) {
    if constexpr (wire_kind<T>() == WireKind::nested) {
      Members{}(value, [&size](const char*, auto&& member) { walk(size, member); });
    } else {
      walk(size, value);
    }
  });
  return size;
}

template <class Element, class Members>
constexpr void walk_elements(auto& stream, auto&& rows) {
  constexpr WireKind kKind = wire_kind<Element>();
  if constexpr (kKind == WireKind::nested) {
    const auto walk_all = [&rows]<std::size_t... Column>(auto& to, std::index_sequence<Column...>) {
      (walk_column<Members, Column>(to, rows), ...);
    };
    constexpr auto kColumns = std::make_index_sequence<columns_of<Element, Members>()>{};
    constexpr WireSize kRow = least<Element, Members>();
    if constexpr (kRow.fixed && requires { stream.block(1, 1); }) {
      auto block = stream.block(std::size(rows), kRow.bytes);
      if (block.at != nullptr) walk_all(block, kColumns);
    } else {
      walk_all(stream, kColumns);
    }
  } else if constexpr (std::is_arithmetic_v<Element> && !std::is_same_v<Element, bool>) {
    stream.numbers(std::data(rows), std::size(rows));
  } else {
    for (auto& element : rows) walk(stream, element);
  }
}

/// Shows a value to a stream, part by part in the order of the wire.
template <class Stream, class V>
constexpr void walk(Stream& stream, V& value) {
  constexpr WireKind kKind = wire_kind<std::remove_cv_t<V>>();
  if constexpr (kKind == WireKind::number) {
    walk_number(stream, value);
  } else if constexpr (kKind == WireKind::text || kKind == WireKind::letters) {
    if constexpr (Stream::kReads) {
      stream.text(value);
    } else {
      stream.text(Stream::kLooksInside ? text_of(value) : std::string_view{});
    }
  } else if constexpr (kKind == WireKind::array) {
    walk_elements<std::remove_cv_t<std::remove_extent_t<V>>, AllMembers>(stream, value);
  } else if constexpr (kKind == WireKind::joined) {
    for (auto* item : value.item) walk_number(stream, *item);
  } else if constexpr (kKind == WireKind::list) {
    using Element = typename V::value_type;
    constexpr std::size_t kLeast = least<Element>().bytes;
    stream.resize(value, kLeast);
    if constexpr (Stream::kLooksInside) walk_elements<Element, AllMembers>(stream, value);
  } else if constexpr (kKind == WireKind::listed) {
    using Number = typename V::Number;
    stream.resize(value.list, sizeof(Number));
    if constexpr (!Stream::kLooksInside) return;
    if constexpr (std::is_same_v<Number, typename std::remove_cvref_t<decltype(value.list)>::value_type>) {
      stream.numbers(std::data(value.list), std::size(value.list));
    } else {
      for (const Number number : value.list) stream.numbers(&number, 1);
    }
  } else if constexpr (kKind == WireKind::counted) {
    constexpr std::size_t kLeast = least<typename V::Element, typename V::Listing>().bytes;
    walk_elements<typename V::Element, typename V::Listing>(stream, stream.bounded(value, kLeast));
  } else if constexpr (kKind == WireKind::widened) {
    typename V::Travels number{};
    if constexpr (!Stream::kReads && Stream::kLooksInside) number = value.value;
    stream.numbers(&number, 1);
    if constexpr (Stream::kReads) {
      value.value = static_cast<std::remove_cvref_t<decltype(value.value)>>(number);
      if (value.value != number) stream.reader.refuse();
    }
  } else {
    visit_members(value, [&stream](const char*, auto&& member) { walk(stream, member); });
  }
}

}  // namespace sortie::drivers::detail
