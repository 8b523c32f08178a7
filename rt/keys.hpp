// SPDX-License-Identifier: BSD-3-Clause
// One list of keys a config struct: what may be written in a profile, in which unit and range, and what it
// means. Reading, help texts, run-time parameters and the knobs of a sweep all follow from it.
//
//   struct SurfelConfig {
//     double cell_m{0.5};
//     rt::Nanoseconds longest_ns{20'000'000};
//     SORTIE_KEYS(c, key) {
//       key("cell_m", c.cell_m, {0.05, 5, "m", "edge of a surfel's cell", rt::kKnob});
//       key("longest_ms", c.longest_ns, {1, 1000, rt::kMsInNs, "that a match may take"});
//     }
//   };
//
// A name with a dot is a whole path, others are in the table that a reader names. The list is walked with
// what has been read so far, so that it may end where a part is not there. A struct inside lists its own:
// Inner::keys(c.inner, key). Set-up only; of all this a run keeps the ranges of its run-time parameters.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "rt/rotation.hpp"

namespace sortie::rt {

/// A unit as it is written, and what one of it is in the member that keeps it.
struct KeyUnit {
  constexpr KeyUnit(const char* as_written, double in_member = 1.0) : name(as_written), kept(in_member) {}
  const char* name;
  double kept;
};

inline constexpr KeyUnit kDegInRad{"deg", 3.14159265358979323846 / 180.0};
inline constexpr KeyUnit kDegSInRadS{"deg/s", kDegInRad.kept};
inline constexpr KeyUnit kUsInNs{"us", 1e3};
inline constexpr KeyUnit kMsInNs{"ms", 1e6};
inline constexpr KeyUnit kSInNs{"s", 1e9};
inline constexpr KeyUnit kMsInS{"ms", 1e-3};

/// What else is true of a key.
enum KeyMarks : std::uint8_t {
  kKnob = 1,  ///< trades error for run time or memory: of interest to a sweep
  kLive = 2,  ///< may be written between two jobs, as it is; where it takes more, the key has a setter
};

/// One of the names that may be written, and the member's value for it: an enumerator, false or true.
struct KeyChoice {
  constexpr KeyChoice() = default;
  template <class T>
  requires(std::is_enum_v<T> || std::is_same_v<T, bool>) constexpr KeyChoice(const char* as_written,
                                                                             T in_member)
      : name(as_written), value(static_cast<int>(in_member)) {}
  const char* name{};
  int value{};
};

/// Where a number may lie, as it is written, and what its key means; of other keys the meaning alone.
/// Profile, help texts and tables of run-time parameters hold it whole. Texts are static.
struct KeyRange {
  double low{};
  double high{};
  KeyUnit unit{""};
  const char* meaning = "";
};

/// What a key may be.
struct KeySpec : KeyRange {
  static constexpr std::size_t kMostChoices = 4;

  /// A number, or three of them, in low .. high, as it is written. With a unit that the member does not keep
  /// it is converted; else a whole member takes whole numbers only.
  constexpr KeySpec(double least, double most, KeyUnit written_in, const char* what, int more = 0)
      : KeyRange{least, most, written_in, what}, marks(more) {}
  /// True or false.
  constexpr KeySpec(const char* what, int more = 0) : KeyRange{.meaning = what}, marks(more) {}
  /// One name of some, in the order in which they are shown.
  template <std::size_t N>
  requires(N <= kMostChoices) constexpr KeySpec(const char* what, const KeyChoice (&names)[N], int more = 0)
      : KeyRange{.meaning = what}, marks(more) {
    for (const KeyChoice& choice : names) choices[count++] = choice;
  }

  int marks;  ///< bits of KeyMarks
  KeyChoice choices[kMostChoices]{};
  std::size_t count{};  ///< of the choices
};

/// Inside a struct: SORTIE_KEYS(c, key) { ... } makes it rt::Keyed.
#define SORTIE_KEYS(config, key)   \
  template <class Self, class Key> \
  static constexpr void keys(Self& config, Key&& key)

namespace detail {
struct NullKey {
  template <class T, class... Setter>
  constexpr void operator()(const char*, T&, const KeySpec&, Setter&&...) const {}
};
}  // namespace detail

/// A struct that lists its keys: key(name, member, spec), or key(name, member, spec, setter) where a number
/// may change while a run goes on: Status setter(owner, what the member would hold), on the group's thread.
template <class T>
concept Keyed = requires(T& value) {
  T::keys(value, detail::NullKey{});
};

/// What is written for a key.
enum class KeyKind : std::uint8_t { number, whole, flag, choice, point };

/// The kind that a member of type T makes of a spec.
template <class T>
constexpr KeyKind kind_of(const KeySpec& spec) {
  if (spec.count > 0) return KeyKind::choice;
  if constexpr (std::is_same_v<T, Vector3>) return KeyKind::point;
  if constexpr (std::is_same_v<T, bool>) return KeyKind::flag;
  return std::is_integral_v<T> && spec.unit.kept == 1.0 ? KeyKind::whole : KeyKind::number;
}

/// What is written, as a member of type T keeps it: a number in the member's unit; a choice by its value.
/// Where a whole member has another unit, what is below one is cut off, of s and ms in ns by way of ms, as it
/// always was: 8.2 ms are 8,199,999 ns, and a recorded log replays. `written` must lie in the spec's range.
template <class T>
T from_written(double written, const KeySpec& spec) {
  if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>) {
    return static_cast<T>(static_cast<int>(written));
  } else if constexpr (std::is_integral_v<T>) {
    if (spec.unit.kept == 1.0) return static_cast<T>(std::llround(written));
    return static_cast<T>(spec.unit.kept < 1e6 ? written * spec.unit.kept
                                               : written * (spec.unit.kept / 1e6) * 1e6);
  } else {
    static_assert(std::is_same_v<T, double>, "a key's member is double, whole, bool, an enum, or Vector3");
    return written * spec.unit.kept;
  }
}

/// The same the other way round. Of all numbers that a member's value may have been written as, this is one
/// with at most six digits behind the point, if there is one.
template <class T>
double as_written(const T& member, const KeySpec& spec) {
  const double exact = static_cast<double>(member) / spec.unit.kept;
  if (spec.unit.kept == 1.0) return exact;
  const double plain = std::round(exact * 1e6) / 1e6;
  return from_written<T>(plain, spec) == member ? plain : exact;
}

}  // namespace sortie::rt
