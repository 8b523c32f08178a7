// SPDX-License-Identifier: BSD-3-Clause
// The LCM type of a struct, from its list of members (wire_rules.hpp): members, fingerprint, .lcm text. Tests
// hold them against lcm-gen's and against drivers/messages/*.lcm.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/wire_rules.hpp"

namespace sortie::drivers {

/// A name of at most four parts. One of more does not compile.
struct LcmName {
  std::string_view part[4]{};
  std::size_t parts{};

  constexpr LcmName with(std::string_view more) const {
    LcmName name = *this;
    if (!more.empty()) name.part[name.parts++] = more;
    return name;
  }
};

/// One member of a message type, as a line of its .lcm file.
struct LcmMember {
  LcmName name{};
  std::string_view type{};  ///< one of LCM's own
  LcmName count{};          ///< the member that counts the first dimension, if one does
  std::size_t extent[3]{};  ///< of the other dimensions
  std::size_t extents{};    ///< of them
};

namespace detail {
template <class V>
constexpr std::string_view lcm_number() {
  if (std::is_same_v<V, bool>) return "boolean";
  if (std::is_floating_point_v<V>) return sizeof(V) == 4 ? "float" : "double";
  return sizeof(V) == 1 ? "int8_t" : sizeof(V) == 2 ? "int16_t" : sizeof(V) == 4 ? "int32_t" : "int64_t";
}

// Bytes in a row are no numbers.
template <class V>
constexpr std::string_view lcm_element() {
  return std::is_same_v<V, std::uint8_t> ? "byte" : lcm_number<V>();
}

constexpr void add_member(auto& sink, LcmMember member, std::string_view type) {
  member.type = type;
  sink(member);
}

template <class V>
constexpr void describe(auto& sink, LcmMember member, const V& value);

// Members of a struct inside; `around.name` stands before their own.
constexpr void describe_inner(auto& sink, const LcmMember& around, const auto& row, const auto& members) {
  members(row, [&](const char* name, const auto& field) {
    LcmMember member = around;
    member.name = around.name.with(name);
    describe(sink, member, field);
  });
}

// What `member` is an array of; the members of structs bear their own names behind `prefix`.
template <class Element, class Members = AllMembers>
constexpr void describe_elements(auto& sink, LcmMember member, const LcmName& prefix) {
  constexpr WireKind kKind = wire_kind<Element>();
  if constexpr (kKind == WireKind::nested) {
    member.name = prefix;
    show<Element>([&](const Element& row) { describe_inner(sink, member, row, Members{}); });
  } else if constexpr (kKind == WireKind::number) {
    add_member(sink, member, lcm_element<Element>());
  } else {
    show<Element>([&](const Element& element) { describe(sink, member, element); });
  }
}

// `member` has its name, and the dimensions of what it lies in.
template <class V>
constexpr void describe(auto& sink, LcmMember member, const V& value) {
  constexpr WireKind kKind = wire_kind<V>();
  if constexpr (kKind == WireKind::number) {
    add_member(sink, member, lcm_number<V>());
  } else if constexpr (kKind == WireKind::text || kKind == WireKind::letters) {
    add_member(sink, member, "string");
  } else if constexpr (kKind == WireKind::array) {
    member.extent[member.extents++] = std::extent_v<V>;
    describe_elements<std::remove_extent_t<V>>(sink, member, member.name.with("_"));
  } else if constexpr (kKind == WireKind::joined) {
    member.extent[member.extents++] = std::size(value.item);
    add_member(sink, member, lcm_element<std::remove_cvref_t<decltype(*value.item[0])>>());
  } else if constexpr (kKind == WireKind::listed) {
    member.count = LcmName{}.with(value.count_name);
    add_member(sink, {member.count}, "int32_t");
    add_member(sink, member, lcm_element<typename V::Number>());
  } else if constexpr (kKind == WireKind::counted) {
    member.count = LcmName{}.with(value.count_name);
    describe_elements<typename V::Element, typename V::Listing>(sink, member, {});
  } else if constexpr (kKind == WireKind::widened) {
    add_member(sink, member, lcm_number<typename V::Travels>());
  } else if constexpr (kKind == WireKind::list) {
    static_assert(wire_kind<typename V::value_type>() == WireKind::nested, "numbers in a list: listed()");
    member.count = member.name;
    add_member(sink, {member.count}, "int32_t");
    describe_elements<typename V::value_type>(sink, member, {});
  } else {
    member.name = member.name.with("_");
    describe_inner(sink, member, value, AllMembers{});
  }
}
}  // namespace detail

/// Calls sink(member) for every member of the type of `value`'s message, in the order of its .lcm file.
template <WireMessage T>
constexpr void visit_lcm_members(const T& value, auto&& sink) {
  bool first = true;
  visit_members(value, [&](const char* name, const auto& field) {
    detail::describe(sink, {LcmName{}.with(name)}, field);
    if (WireRules<T>::kNumbered && first) detail::add_member(sink, {LcmName{}.with("seq")}, "int64_t");
    first = false;
  });
  if (WireRules<T>::kTagged) detail::add_member(sink, {LcmName{}.with("tag")}, "int64_t");
}

namespace detail {
// As lcm-gen has it: the shift to the right keeps the sign.
constexpr std::int64_t hash_on(std::int64_t hash, std::int64_t next) {
  const auto mixed = (static_cast<std::uint64_t>(hash) << 8) ^ static_cast<std::uint64_t>(hash >> 55);
  return static_cast<std::int64_t>(mixed + static_cast<std::uint64_t>(next));
}
constexpr std::int64_t hash_on(std::int64_t hash, const LcmName& name) {
  std::int64_t length = 0;
  for (const std::string_view part : name.part) length += static_cast<std::int64_t>(part.size());
  hash = hash_on(hash, length);
  for (const std::string_view part : name.part) {
    for (const char letter : part) hash = hash_on(hash, std::int64_t{letter});
  }
  return hash;
}
constexpr std::int64_t hash_on(std::int64_t hash, std::size_t number) {
  char digits[20]{};
  std::size_t at = sizeof digits;
  for (; number != 0; number /= 10) digits[--at] = static_cast<char>('0' + number % 10);
  return hash_on(hash, LcmName{}.with({digits + at, sizeof digits - at}));
}

template <class T>
constexpr bool no_name_twice() {
  std::int64_t name[256]{};  // by their hashes
  std::size_t names = 0;
  bool twice = false;
  const auto add = [&](const LcmMember& member) {
    const std::int64_t own = hash_on(0, member.name);
    for (std::size_t i = 0; i < names; ++i) twice = twice || name[i] == own;
    name[names++] = own;
  };
  show<T>([&add](const T& value) { visit_lcm_members(value, add); });
  return !twice;
}

template <class T>
constexpr std::uint64_t fingerprint() {
  static_assert(no_name_twice<T>(), "two members of the message have one name");
  std::int64_t hash = 0x12345678;
  const auto add = [&hash](const LcmMember& member) {
    const bool counted = member.count.parts > 0;
    hash = hash_on(hash_on(hash, member.name), LcmName{}.with(member.type));
    hash = hash_on(hash, static_cast<std::int64_t>(member.extents + (counted ? 1 : 0)));
    if (counted) hash = hash_on(hash_on(hash, std::int64_t{1}), member.count);
    for (std::size_t i = 0; i < member.extents; ++i)
      hash = hash_on(hash_on(hash, std::int64_t{0}), member.extent[i]);
  };
  show<T>([&add](const T& value) { visit_lcm_members(value, add); });
  return std::rotl(static_cast<std::uint64_t>(hash), 1);
}
}  // namespace detail

/// The first eight bytes of every message of T, as lcm-gen computes them from the members.
template <WireMessage T>
inline constexpr std::uint64_t kFingerprintOf = detail::fingerprint<T>();

/// The .lcm file of T's messages as a type called `name`, without comments. Not for the real-time path.
template <WireMessage T>
std::string lcm_text(std::string_view name) {
  std::string text = "package sortie;\n\nstruct ";
  const auto add = [&text](const LcmName& words) {
    for (const std::string_view part : words.part) text += part;
  };
  text.append(name).append(" {\n");
  visit_lcm_members(T{}, [&](const LcmMember& member) {
    text.append("  ").append(member.type).append(" ");
    add(member.name);
    if (member.count.parts > 0) {
      text += "[";
      add(member.count);
      text += "]";
    }
    for (std::size_t i = 0; i < member.extents; ++i) text += "[" + std::to_string(member.extent[i]) + "]";
    text += ";\n";
  });
  return text.append("}\n");
}

}  // namespace sortie::drivers
