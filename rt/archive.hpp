// SPDX-License-Identifier: BSD-3-Clause
// State to bytes and back: one function of an object serves both directions, so they cannot drift apart.
//
//   class Filter {
//    public:
//     void archive(rt::Archive& archive) {
//       rt::Members(archive, *this, "filter").state(mean_, started_).fixed(config_);
//     }
//    ...
//   };
//
// Every data member is named: as state, or as something that is not. What nobody named is noticed at the
// first pass, by the bytes of the object that were left over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "rt/fields.hpp"
#include "rt/status.hpp"

namespace sortie::rt {

class Archive;

/// A type that archives itself.
template <class T>
concept Archived = requires(T& value, Archive& archive) {
  value.archive(archive);
};

namespace detail {
template <class T>
struct StdArray : std::false_type {};
template <class T, std::size_t N>
struct StdArray<std::array<T, N>> : std::true_type {};

template <class T>
constexpr bool is_archivable() {
  if constexpr (std::is_array_v<T>) {
    return is_archivable<std::remove_extent_t<T>>();
  } else if constexpr (StdArray<T>::value) {
    return is_archivable<typename T::value_type>();
  } else {
    return Archived<T> || Described<T> || std::is_arithmetic_v<T> || std::is_enum_v<T>;
  }
}
}  // namespace detail

/// What an archive takes: what archives itself or lists its fields, a number, an enum, or an array of such.
template <class T>
concept Archivable = detail::is_archivable<T>();

/// One pass over a state, in one of three modes: count the bytes and look for forgotten members, write them,
/// or read them back. The bytes are the canonical form: little endian, fixed width, no padding, every NaN the
/// same, so that any processor reads what any other wrote. No heap, no exception; never outside its bytes,
/// whatever they hold. After the first fault nothing more is read or written and everything read is zero.
/// Cost: a few ns a value; not for the real-time path.
class Archive {
 public:
  /// Counts.
  static Archive measuring() { return Archive(Mode::measure, nullptr, nullptr, 0); }
  /// Writes into `out`; `full` when that is too small.
  static Archive writing(std::span<std::uint8_t> out) {
    return Archive(Mode::write, out.data(), nullptr, out.size());
  }
  /// Reads from `in`.
  static Archive reading(std::span<const std::uint8_t> in) {
    return Archive(Mode::read, nullptr, in.data(), in.size());
  }

  bool is_measuring() const { return mode_ == Mode::measure; }
  bool is_reading() const { return mode_ == Mode::read; }
  /// ok; full (writing); malformed (the bytes are not of this state); not_supported (a member was forgotten,
  /// or something cannot be archived).
  Status status() const { return status_; }
  /// Where the first fault happened, and what it was; static texts, empty without a fault.
  const char* where() const { return where_; }
  const char* why() const { return why_; }
  /// Bytes counted, written or read so far.
  std::uint64_t bytes() const { return used_; }

  /// Archives one value.
  template <Archivable T>
  void value(T& value) {
    if constexpr (Archived<T>) {
      value.archive(*this);
    } else if constexpr (std::is_array_v<T> || detail::StdArray<T>::value) {
      for (auto& element : value) this->value(element);
    } else if constexpr (Described<T>) {
      described(value);
    } else {
      scalar(value);
    }
  }

  /// A length or an index that must not be above `most`.
  void bounded(std::uint32_t& value, std::uint64_t most) {
    scalar(value);
    if (is_reading() && value > most) {
      fail(Status::malformed, "a length is larger than the memory for it");
      value = 0;
    }
  }
  /// A number that is the same wherever this state fits: a capacity, a mark between parts.
  void expect(std::uint64_t number, const char* why) {
    std::uint64_t found = number;
    scalar(found);
    if (is_reading() && found != number) fail(Status::malformed, why);
  }
  /// Notes a fault. `why` is a static text. The first one stays.
  void fail(Status status, const char* why) {
    if (status_ != Status::ok) return;
    status_ = status;
    where_ = object_;
    why_ = why;
  }

 private:
  template <class Object>
  friend class Members;
  enum class Mode : std::uint8_t { measure, write, read };

  Archive(Mode mode, std::uint8_t* out, const std::uint8_t* in, std::uint64_t size)
      : mode_(mode), out_(out), in_(in), size_(size) {}

  template <class T>
  void scalar(T& value) {
    if (mode_ == Mode::measure) {
      used_ += sizeof(T);
      return;
    }
    if (mode_ == Mode::read) value = T{};
    if (status_ != Status::ok) return;
    if (sizeof(T) > size_ - used_) {
      fail(mode_ == Mode::write ? Status::full : Status::malformed, "the bytes end too early");
      return;
    }
    if (mode_ == Mode::write) {
      detail::encode_one(out_ + used_, value);
    } else {
      if constexpr (std::is_same_v<T, bool>) {
        if (in_[used_] > 1) fail(Status::malformed, "a truth value is neither 0 nor 1");
      }
      detail::decode_one(in_ + used_, value);
    }
    used_ += sizeof(T);
  }
  template <class T>
  void described(T& value);

  Mode mode_;
  Status status_{Status::ok};
  std::uint8_t* out_;
  const std::uint8_t* in_;
  std::uint64_t size_;
  std::uint64_t used_{};
  const char* object_{"state"};
  const char* where_{""};
  const char* why_{""};
};

/// The data members of one object. When the last of them has been named, the destructor compares (in a
/// measuring pass) what was named with what the object consists of. A forgotten member that fits into the
/// padding between two others is not seen; everything larger is.
template <class Object>
class Members {
 public:
  /// `name`: static text for messages.
  Members(Archive& archive, Object& object, const char* name)
      : archive_(archive), object_(object), outer_(archive.object_) {
    archive.object_ = name;
    if constexpr (std::is_polymorphic_v<Object>) note(&object, sizeof(void*), alignof(void*));
  }
  ~Members() {
    if (archive_.is_measuring()) check();
    archive_.object_ = outer_;
  }
  Members(const Members&) = delete;
  Members& operator=(const Members&) = delete;

  /// Members that a later job may read: archived.
  template <Archivable... T>
  Members& state(T&... members) {
    (note(&members, sizeof(T), alignof(T)), ...);
    (archive_.value(members), ...);
    return *this;
  }
  /// Set at construction, from the profile or as memory: the same in every run of the scene.
  template <class... T>
  Members& fixed(const T&... members) {
    (note(&members, sizeof(T), alignof(T)), ...);
    return *this;
  }
  /// Written by each job before it is read, or measured and never read by a task.
  template <class... T>
  Members& scratch(const T&... members) {
    return fixed(members...);
  }
  /// State that the caller archives by hand.
  template <class... T>
  Members& by_hand(const T&... members) {
    return fixed(members...);
  }
  /// A base class that was archived, or has nothing to archive.
  template <class Base>
  Members& base() {
    note(static_cast<const Base*>(&object_), sizeof(Base), alignof(Base));
    return *this;
  }

 private:
  static constexpr std::uint32_t kMost = 64;
  struct Part {
    std::size_t begin;
    std::size_t end;
    std::size_t alignment;
  };

  void note(const void* member, std::size_t size, std::size_t alignment) {
    if (!archive_.is_measuring()) return;
    const auto begin = reinterpret_cast<std::uintptr_t>(member) - reinterpret_cast<std::uintptr_t>(&object_);
    if (begin > sizeof(Object) || size > sizeof(Object) - begin)
      return archive_.fail(Status::not_supported, "a member is named that belongs to another object");
    if (count_ == kMost)
      return archive_.fail(Status::not_supported, "more members than can be watched; group them in structs");
    std::uint32_t at = count_++;
    for (; at > 0 && parts_[at - 1].begin > begin; --at) parts_[at] = parts_[at - 1];
    parts_[at] = {begin, begin + size, alignment};
  }

  void check() {
    std::size_t end = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (parts_[i].begin > aligned(end, parts_[i].alignment)) return forgotten();
      end = parts_[i].end > end ? parts_[i].end : end;
    }
    if (aligned(end, alignof(Object)) < sizeof(Object)) forgotten();
  }
  void forgotten() {
    archive_.fail(
        Status::not_supported,
        "a member is neither archived nor declared to be no state; name it in archive() or fields()");
  }
  static constexpr std::size_t aligned(std::size_t offset, std::size_t alignment) {
    return (offset + alignment - 1) / alignment * alignment;
  }

  Archive& archive_;
  Object& object_;
  const char* outer_;
  std::uint32_t count_{};
  Part parts_[kMost];
};

template <class T>
void Archive::described(T& value) {
  if (is_measuring()) {
    Members<T> members(*this, value, object_);
    T::fields(value, [&members](const char*, auto& field) { members.state(field); });
  } else {
    T::fields(value, [this](const char*, auto& field) { this->value(field); });
  }
}

}  // namespace sortie::rt
