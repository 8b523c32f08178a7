// SPDX-License-Identifier: BSD-3-Clause
// How a struct lies in a message: member for member as its list of fields (rt/fields.hpp), but for what its
// WireRules say. Codec (wire_fields.hpp) and LCM type (lcm_type.hpp) both follow from that.
//
//   number, enum, bool        a number; unsigned ones travel as signed ones of the same bits
//   C array of numbers        name[N]; of std::uint8_t: byte name[N]
//   text, char[N]             string; char[N] holds it up to the first zero
//   another struct            its members, each as name_member
//   C array of structs        an array name_member[N] for each of their members
//   vector, span, FixedVector of structs: their number, under the list's name, and an array for each member
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "rt/fields.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// What a message has beside the members of its struct.
struct WirePlain {
  static constexpr bool kNumbered = false;  ///< `seq`, its number in its stream, follows the first member
  static constexpr bool kTagged = false;    ///< it ends with `tag`, as wire_fields.hpp has it
};
struct WireNumbered : WirePlain {
  static constexpr bool kNumbered = true;
};
struct WireTagged : WirePlain {
  static constexpr bool kTagged = true;
};

/// Specialised, in the header that messages of T are used with, where they are not the fields of T alone.
/// A specialisation may have:
///   members(self, visit)  lists the members instead of T::fields, made like it
///   taken(value)          false: no such value is taken, the message is `malformed`
///   sent(value)           false: no such value is written, it is `out_of_range`
template <class T>
struct WireRules : WirePlain {};

namespace detail {
struct AnyVisitor {
  constexpr void operator()(const char*, auto&&) const {}
};
template <class T>
concept ListsMembers = requires(T& value) {
  WireRules<std::remove_const_t<T>>::members(value, AnyVisitor{});
};
}  // namespace detail

/// A struct that can be a message.
template <class T>
concept WireMessage = rt::Described<T> || detail::ListsMembers<T>;

/// Calls visit(name, member) for every member of a message or of a row, in the order of the wire.
template <class T, class Visitor>
constexpr void visit_members(T& value, Visitor&& visit) {
  if constexpr (detail::ListsMembers<T>) {
    WireRules<std::remove_const_t<T>>::members(value, visit);
  } else {
    std::remove_const_t<T>::fields(value, visit);
  }
}

namespace detail {
enum class WireKind { number, letters, text, array, joined, list, listed, counted, widened, nested };

/// Memory of a T that nobody made.
template <class T>
union Unmade {
  char none{};
  T value;
  constexpr Unmade() {}
  constexpr ~Unmade() {}
};
/// Shows a T at compile time. What has texts or vectors is not made for that (clang 14 cannot): it is there
/// to be named, not to be read.
template <class T>
constexpr void show(auto&& look) {
  if constexpr (std::is_trivially_destructible_v<T>) {
    T value{};
    look(value);
  } else {
    Unmade<T> unmade;
    look(unmade.value);
  }
}

struct AllMembers {
  constexpr void operator()(auto& row, auto&& visit) const { visit_members(row, visit); }
};
}  // namespace detail

/// For members(): a list of numbers, with their count before them as a member of that name. `Element`: as
/// they travel, if that is another type.
template <class Element, class List>
struct WireListed {
  static constexpr detail::WireKind kWireKind = detail::WireKind::listed;
  using Number = std::conditional_t<std::is_void_v<Element>, typename List::value_type, Element>;
  const char* count_name;
  List& list;
};
template <class Element = void, class List>
constexpr auto listed(const char* count_name, List& list) {
  return WireListed<Element, List>{count_name, list};
}

/// For members(): the first `count` of an array of numbers, or of structs, which become an array for each of
/// their members (those that `members` lists). The count was visited before, under that name; where a message
/// has more than `room` holds, it is refused with `beyond`.
template <class Item, class Count, class Members>
struct WireCounted {
  static constexpr detail::WireKind kWireKind = detail::WireKind::counted;
  using Element = std::remove_const_t<Item>;
  using Listing = Members;
  const char* count_name;
  std::span<Item> room;
  Count& count;
  Status beyond;
};
template <class Members = detail::AllMembers, class Item, std::size_t Extent, class Count>
constexpr auto counted(const char* count_name, std::span<Item, Extent> room, Count& count,
                       Status beyond = Status::full, Members = {}) {
  return WireCounted<Item, Count, Members>{count_name, room, count, beyond};
}

/// For members(), but not in rows: a number that travels as a `Number`, which holds all that it can be. One
/// that is read and does not fit is refused.
template <class Number, class Value>
struct WireWidened {
  static constexpr detail::WireKind kWireKind = detail::WireKind::widened;
  using Travels = Number;
  Value& value;
};
template <class Number, class Value>
constexpr auto widened(Value& value) {
  return WireWidened<Number, Value>{value};
}

/// For members(): several numbers of one type as one array.
template <class Item, std::size_t N>
struct WireJoined {
  static constexpr detail::WireKind kWireKind = detail::WireKind::joined;
  Item* item[N];
};
template <class Item, class... Rest>
constexpr auto joined(Item& first, Rest&... rest) {
  return WireJoined<Item, 1 + sizeof...(Rest)>{{&first, &rest...}};
}

namespace detail {
template <class V>
constexpr WireKind wire_kind() {
  if constexpr (requires { V::kWireKind; }) {
    return V::kWireKind;
  } else if constexpr (std::is_arithmetic_v<V> || std::is_enum_v<V>) {
    return WireKind::number;
  } else if constexpr (std::is_array_v<V>) {
    return std::is_same_v<std::remove_extent_t<V>, char> ? WireKind::letters : WireKind::array;
  } else if constexpr (std::is_same_v<V, std::string> || std::is_same_v<V, std::string_view>) {
    return WireKind::text;
  } else {
    return requires(V & list) { list.size(); }
    ? WireKind::list : WireKind::nested;
  }
}
}  // namespace detail

}  // namespace sortie::drivers
