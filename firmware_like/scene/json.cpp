// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/json.hpp"

#include <algorithm>
#include <iterator>

namespace sortie::firmware {

/// The key of a value has its value's index.
struct Json::Members {
  std::vector<std::string> keys;
  std::vector<Json> values;

  std::size_t index(std::string_view key) const {
    return static_cast<std::size_t>(std::find(keys.begin(), keys.end(), key) - keys.begin());
  }
  Json& add(std::string key, Json value) {
    keys.push_back(std::move(key));
    return values.emplace_back(std::move(value));
  }
};

Json::Json(const char* text) : Json(std::string(text)) {}
Json::Json(std::string_view text) : Json(std::string(text)) {}
Json::Json(std::string text) {
  become(Kind::text);
  *value_.text = std::move(text);
}

Json::Json(std::initializer_list<JsonListItem> items) {
  const bool is_pairs = std::all_of(items.begin(), items.end(), [](const JsonListItem& item) {
    const Json& pair = item.value();
    return pair.is_array() && pair.size() == 2 && pair[std::size_t{0}].is_string();
  });
  if (!is_pairs) {
    *this = array(items);
    return;
  }
  become(Kind::object);
  for (const JsonListItem& item : items) {
    Json pair = item.take();
    std::string& key = *(*pair.value_.array)[0].value_.text;
    if (value_.object->index(key) == size()) value_.object->add(std::move(key), std::move(pair.back()));
  }
}

Json::Json(const Json& other) : kind_(other.kind_), value_(other.value_) {
  if (kind_ == Kind::text) value_.text = new std::string(*other.value_.text);
  if (kind_ == Kind::array) value_.array = new std::vector<Json>(*other.value_.array);
  if (kind_ == Kind::object) value_.object = new Members(*other.value_.object);
}

Json& Json::operator=(const Json& other) { return *this = Json(other); }

Json& Json::operator=(Json&& other) noexcept {
  // What is taken may be a part of this value.
  Json old(std::move(*this));
  std::swap(kind_, other.kind_);
  std::swap(value_, other.value_);
  return *this;
}

Json Json::array(std::initializer_list<JsonListItem> items) {
  Json json;
  json.become(Kind::array);
  json.value_.array->reserve(items.size());
  for (const JsonListItem& item : items) json.value_.array->push_back(item.take());
  return json;
}

Json Json::object() {
  Json json;
  json.become(Kind::object);
  return json;
}

std::size_t Json::size() const {
  if (kind_ == Kind::array) return value_.array->size();
  if (kind_ == Kind::object) return value_.object->values.size();
  return is_null() ? 0 : 1;
}

const Json* Json::begin() const {
  if (kind_ == Kind::array) return value_.array->data();
  if (kind_ == Kind::object) return value_.object->values.data();
  if (!is_null()) refuse("an array");
  return nullptr;
}

const Json* Json::end() const {
  if (kind_ == Kind::array) return value_.array->data() + value_.array->size();
  if (kind_ == Kind::object) return value_.object->values.data() + value_.object->values.size();
  return nullptr;
}

const Json& Json::operator[](std::size_t index) const {
  if (!is_array()) refuse("an array");
  if (index >= value_.array->size())
    throw JsonError("JSON: an array has no element " + std::to_string(index));
  return (*value_.array)[index];
}

Json& Json::operator[](std::size_t index) { return const_cast<Json&>(std::as_const(*this)[index]); }

const Json* Json::find(std::string_view key) const {
  if (!is_object()) return end();
  return value_.object->values.data() + value_.object->index(key);
}

const Json* Json::member(std::string_view key) const {
  const Members& members = as_object();
  const std::size_t index = members.index(key);
  return index < members.values.size() ? &members.values[index] : nullptr;
}

const Json& Json::at(std::string_view key) const {
  const Json* const found = member(key);
  if (found == nullptr) throw JsonError("JSON: there is no '" + std::string(key) + "'");
  return *found;
}

Json& Json::operator[](std::string_view key) {
  if (is_null()) become(Kind::object);
  if (const Json* const found = member(key); found != nullptr) return const_cast<Json&>(*found);
  return value_.object->add(std::string(key), Json());
}

std::string Json::value(std::string_view key, const char* fallback) const {
  const Json* const found = member(key);
  return found == nullptr ? fallback : found->as_text();
}

JsonItems::JsonItems(const Json& object) {
  if (object.is_null()) return;
  const Json::Members& members = object.as_object();
  begin_ = {members.keys.data(), members.values.data()};
  end_ = {members.keys.data() + members.keys.size(), members.values.data() + members.values.size()};
}

void Json::push_back(Json value) {
  if (is_null()) become(Kind::array);
  if (!is_array()) refuse("an array");
  value_.array->push_back(std::move(value));
}

void Json::push_back(std::initializer_list<JsonListItem> items) { push_back(Json(items)); }

void Json::erase(std::string_view key) {
  Members& members = const_cast<Members&>(as_object());
  const auto index = static_cast<std::ptrdiff_t>(members.index(key));
  if (index == std::ssize(members.keys)) return;
  members.keys.erase(members.keys.begin() + index);
  members.values.erase(members.values.begin() + index);
}

void Json::update(const Json& other) {
  for (const auto& [key, value] : JsonItems(other)) (*this)[key] = value;
}

bool operator==(const Json& a, const Json& b) {
  using Kind = Json::Kind;
  if (a.is_number() && b.is_number()) {
    if (a.kind_ == Kind::real || b.kind_ == Kind::real) return a.as_real() == b.as_real();
    if (a.kind_ == Kind::count && b.kind_ == Kind::count) return a.value_.count == b.value_.count;
    if (a.kind_ == Kind::count) return std::cmp_equal(a.value_.count, b.value_.integer);
    if (b.kind_ == Kind::count) return std::cmp_equal(a.value_.integer, b.value_.count);
    return a.value_.integer == b.value_.integer;
  }
  if (a.kind_ != b.kind_) return false;
  if (a.kind_ == Kind::boolean) return a.value_.boolean == b.value_.boolean;
  if (a.kind_ == Kind::text) return *a.value_.text == *b.value_.text;
  if (a.kind_ == Kind::array) return *a.value_.array == *b.value_.array;
  if (a.kind_ != Kind::object) return true;
  return a.value_.object->keys == b.value_.object->keys && a.value_.object->values == b.value_.object->values;
}

const std::string& Json::as_text() const {
  if (!is_string()) refuse("a text");
  return *value_.text;
}

const Json::Members& Json::as_object() const {
  if (!is_object()) refuse("an object");
  return *value_.object;
}

bool Json::as_bool() const {
  if (!is_boolean()) refuse("true or false");
  return value_.boolean;
}

double Json::as_real() const {
  if (!is_number()) refuse("a number");
  if (kind_ == Kind::real) return value_.real;
  return kind_ == Kind::count ? static_cast<double>(value_.count) : static_cast<double>(value_.integer);
}

std::int64_t Json::as_integer() const {
  if (kind_ == Kind::count) return static_cast<std::int64_t>(value_.count);
  if (kind_ == Kind::integer) return value_.integer;
  const double real = as_real();
  if (!(real >= -0x1p63 && real < 0x1p63)) refuse("a whole number that fits");
  return static_cast<std::int64_t>(real);
}

std::uint64_t Json::as_count() const {
  if (kind_ == Kind::count) return value_.count;
  if (kind_ == Kind::integer) return static_cast<std::uint64_t>(value_.integer);
  const double real = as_real();
  if (!(real > -1.0 && real < 0x1p64)) refuse("a whole number that fits");
  return static_cast<std::uint64_t>(real);
}

void Json::become(Kind kind) {
  if (kind == Kind::text) value_.text = new std::string;
  if (kind == Kind::array) value_.array = new std::vector<Json>;
  if (kind == Kind::object) value_.object = new Members;
  kind_ = kind;
}

void Json::release() noexcept {
  if (kind_ == Kind::text) delete value_.text;
  if (kind_ == Kind::array) delete value_.array;
  if (kind_ == Kind::object) delete value_.object;
}

void Json::refuse(const char* wanted) const {
  constexpr const char* kNames[] = {"null",     "true or false", "a number", "a number",
                                    "a number", "a text",        "an array", "an object"};
  throw JsonError(std::string("JSON: ") + kNames[static_cast<std::size_t>(kind_)] + " is not " + wanted);
}

}  // namespace sortie::firmware
