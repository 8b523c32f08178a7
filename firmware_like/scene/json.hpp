// SPDX-License-Identifier: BSD-3-Clause
// JSON values: made, read, written and parsed. What they are called and what they do is what
// nlohmann::ordered_json does; that library is included by json_text.cpp alone, because one reading of it
// takes seconds.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace sortie::firmware {

class Json;
class JsonItems;
class JsonListItem;

/// A text is no JSON, or a value is not of the kind, or has not the key, that was asked for.
class JsonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What becomes an array, or an object where it has keys: std::vector, std::map and their like.
template <class R>
concept JsonRange = !std::is_same_v<R, Json> && !std::is_convertible_v<const R&, std::string_view> &&
                    requires(const R& range) {
  typename R::value_type;
  range.begin();
  range.end();
};

/// One JSON value. Members of an object keep the order in which they came. References to elements and members
/// last until the next one is added. What is called with a value of the wrong kind throws JsonError.
class Json {
 public:
  /// So many arrays and objects may stand in one another in a text that is parsed.
  static constexpr int kMostDepth = 100;

  /// Null, or what the argument is.
  Json() noexcept = default;
  Json(std::nullptr_t) noexcept {}
  template <class T>
  requires std::is_arithmetic_v<T> Json(T value)
  noexcept;
  Json(const char* text);
  Json(std::string_view text);
  Json(std::string text);
  template <JsonRange R>
  Json(const R& range);
  /// An object where each item is a pair that begins with a text, an array otherwise. Of equal keys the first
  /// counts.
  Json(std::initializer_list<JsonListItem> items);
  Json(const Json& other);
  Json(Json&& other) noexcept : kind_(other.kind_), value_(other.value_) { other.kind_ = Kind::null; }
  Json& operator=(const Json& other);
  Json& operator=(Json&& other) noexcept;
  ~Json() {
    if (kind_ >= Kind::text) release();
  }

  /// An array of the items, whatever they look like.
  static Json array(std::initializer_list<JsonListItem> items = {});
  /// An object without members.
  static Json object();

  /// Reads one value. Of equal keys the last counts. Throws JsonError where the text is something else, or
  /// deeper than kMostDepth.
  static Json parse(std::string_view text);
  /// The same; null instead of an exception.
  static Json parse_or_null(std::string_view text);
  /// All that is left in a stream; null where that is no JSON or the stream is not good.
  static Json parse_or_null(std::istream& in);
  /// As text: on one line, or with so many spaces a level. Numbers that are not finite become null, bytes
  /// that are no UTF-8 become U+FFFD.
  [[nodiscard]] std::string dump(int indent = -1) const;

  /// What kind of value this is.
  [[nodiscard]] bool is_null() const { return kind_ == Kind::null; }
  [[nodiscard]] bool is_boolean() const { return kind_ == Kind::boolean; }
  [[nodiscard]] bool is_number() const { return kind_ >= Kind::integer && kind_ <= Kind::real; }
  /// Without a fraction or exponent, with or without a sign.
  [[nodiscard]] bool is_number_integer() const { return kind_ == Kind::integer || kind_ == Kind::count; }
  /// Parsed without a sign, or made from an unsigned type.
  [[nodiscard]] bool is_number_unsigned() const { return kind_ == Kind::count; }
  [[nodiscard]] bool is_number_float() const { return kind_ == Kind::real; }
  [[nodiscard]] bool is_string() const { return kind_ == Kind::text; }
  [[nodiscard]] bool is_array() const { return kind_ == Kind::array; }
  [[nodiscard]] bool is_object() const { return kind_ == Kind::object; }

  /// Elements or members; 0 of null, 1 of any other value.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] bool empty() const { return size() == 0; }

  /// Elements of an array, values of an object, nothing of null.
  [[nodiscard]] const Json* begin() const;
  [[nodiscard]] const Json* end() const;
  [[nodiscard]] Json* begin() { return const_cast<Json*>(std::as_const(*this).begin()); }
  [[nodiscard]] Json* end() { return const_cast<Json*>(std::as_const(*this).end()); }
  [[nodiscard]] const Json& front() const { return (*this)[std::size_t{0}]; }
  [[nodiscard]] const Json& back() const { return (*this)[size() - 1]; }
  [[nodiscard]] Json& back() { return (*this)[size() - 1]; }
  /// Element of an array; throws beyond its end.
  [[nodiscard]] const Json& operator[](std::size_t index) const;
  [[nodiscard]] Json& operator[](std::size_t index);

  /// The member's value, end() without it.
  [[nodiscard]] const Json* find(std::string_view key) const;
  [[nodiscard]] bool contains(std::string_view key) const { return find(key) != end(); }
  /// The member's value; throws without it.
  [[nodiscard]] const Json& at(std::string_view key) const;
  [[nodiscard]] const Json& operator[](std::string_view key) const { return at(key); }
  /// The member's value, added as null where there is none. Null becomes an object.
  [[nodiscard]] Json& operator[](std::string_view key);
  /// The member's value, `fallback` without it.
  template <class T>
  [[nodiscard]] T value(std::string_view key, const T& fallback) const;
  [[nodiscard]] std::string value(std::string_view key, const char* fallback) const;
  /// All members, each as {key, value}.
  [[nodiscard]] JsonItems items() const;

  /// Adds an element. Null becomes an array.
  void push_back(Json value);
  /// Adds what the braces make.
  void push_back(std::initializer_list<JsonListItem> items);
  /// Takes a member away, if there is one.
  void erase(std::string_view key);
  /// Takes over all members of another object. Null becomes an object.
  void update(const Json& other);

  /// bool, a number, std::string, Json, or a vector of these. Integers are cast as C++ casts them, numbers
  /// with a fraction are cut; throws where that is not defined.
  template <class T>
  [[nodiscard]] T get() const;
  /// The same, into a variable.
  template <class T>
  void get_to(T& value) const {
    value = get<T>();
  }

  /// Equal values; numbers by their value, whatever their type. Members must have the same order.
  friend bool operator==(const Json& a, const Json& b);

 private:
  friend class JsonItems;

  enum class Kind : std::uint8_t { null, boolean, integer, count, real, text, array, object };

  struct Members;

  union Value {
    bool boolean;
    std::int64_t integer;
    std::uint64_t count;
    double real;
    std::string* text;
    std::vector<Json>* array;
    Members* object;
  };

  const std::string& as_text() const;
  const Members& as_object() const;
  bool as_bool() const;
  double as_real() const;
  std::int64_t as_integer() const;
  std::uint64_t as_count() const;
  const Json* member(std::string_view key) const;
  void become(Kind kind);
  void release() noexcept;
  [[noreturn]] void refuse(const char* wanted) const;

  Kind kind_{Kind::null};
  Value value_{};
};

/// One item between braces: a value, or items between braces of their own.
class JsonListItem {
 public:
  JsonListItem() = default;
  JsonListItem(const char* text) : value_(text) {}
  JsonListItem(std::initializer_list<JsonListItem> items) : value_(items) {}
  template <class T>
  requires(!std::is_same_v<std::remove_cvref_t<T>, JsonListItem>) JsonListItem(T&& value)
      : value_(std::forward<T>(value)) {}
  [[nodiscard]] const Json& value() const { return value_; }
  /// The value, once: what is in braces is const, and would be copied at each level.
  [[nodiscard]] Json take() const { return std::move(value_); }

 private:
  mutable Json value_;
};

/// The members of an object, for a loop: `for (const auto& [key, value] : object.items())`.
class JsonItems {
 public:
  class Iterator {
   public:
    Iterator(const std::string* key, const Json* value) : key_(key), value_(value) {}
    std::pair<const std::string&, const Json&> operator*() const { return {*key_, *value_}; }
    Iterator& operator++() {
      ++key_;
      ++value_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return value_ == other.value_; }

   private:
    const std::string* key_;
    const Json* value_;
  };

  explicit JsonItems(const Json& object);
  [[nodiscard]] Iterator begin() const { return begin_; }
  [[nodiscard]] Iterator end() const { return end_; }

 private:
  Iterator begin_{nullptr, nullptr};
  Iterator end_{nullptr, nullptr};
};

inline JsonItems Json::items() const { return JsonItems(*this); }

/// As dump() writes it.
std::ostream& operator<<(std::ostream& out, const Json& json);

template <class T>
requires std::is_arithmetic_v<T> Json::Json(T value)
noexcept {
  if constexpr (std::is_same_v<T, bool>) {
    kind_ = Kind::boolean;
    value_.boolean = value;
  } else if constexpr (std::is_floating_point_v<T>) {
    kind_ = Kind::real;
    value_.real = static_cast<double>(value);
  } else if constexpr (std::is_signed_v<T>) {
    kind_ = Kind::integer;
    value_.integer = value;
  } else {
    kind_ = Kind::count;
    value_.count = value;
  }
}

template <JsonRange R>
Json::Json(const R& range) {
  if constexpr (requires { typename R::mapped_type; }) {
    become(Kind::object);
    for (const auto& [key, value] : range) (*this)[key] = value;
  } else {
    become(Kind::array);
    for (const auto& value : range) push_back(Json(value));
  }
}

template <class T>
T Json::value(std::string_view key, const T& fallback) const {
  const Json* const found = member(key);
  return found == nullptr ? fallback : found->get<T>();
}

template <class T>
T Json::get() const {
  if constexpr (std::is_same_v<T, Json>) {
    return *this;
  } else if constexpr (std::is_same_v<T, bool>) {
    return as_bool();
  } else if constexpr (std::is_same_v<T, std::string>) {
    return as_text();
  } else if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(as_real());
  } else if constexpr (std::is_integral_v<T>) {
    if constexpr (std::is_signed_v<T>) return static_cast<T>(as_integer());
    return static_cast<T>(as_count());
  } else {
    if (!is_array()) refuse("an array");
    T values;
    for (const Json& value : *this) values.push_back(value.get<typename T::value_type>());
    return values;
  }
}

}  // namespace sortie::firmware
