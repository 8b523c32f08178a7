// SPDX-License-Identifier: BSD-3-Clause
// Reading results back from JSON: keys may be missing, but what is there must have the right type.
#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

/// A figure as JSON; null when it is not finite.
inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// Every field that a struct lists (rt/describe.hpp), under its name.
template <class T>
Json json_of(const T& value) {
  Json object = Json::object();
  T::fields(value, [&object]<class Field>(const char* name, const Field& field) {
    if constexpr (std::is_floating_point_v<Field>)
      object[name] = json_number(field);
    else
      object[name] = field;
  });
  return object;
}

/// Reads keys of one object; remembers where it is, so that a wrong type can be named. Throws
/// std::runtime_error.
class JsonReader {
 public:
  JsonReader(const Json& object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object.is_object()) throw std::runtime_error(place_ + ": is no JSON object");
  }
  const Json* find(const char* key) const {
    const auto found = object_.find(key);
    return found == object_.end() ? nullptr : &*found;
  }
  void read(const char* key, std::string& value) const {
    if (const Json* json = find(key))
      value = check(json->is_string(), key, *json, "a text").get<std::string>();
  }
  void read(const char* key, double& value) const {
    if (const Json* json = find(key)) value = figure(key, *json);
  }
  void read(const char* key, std::uint64_t& value) const {
    if (const Json* json = find(key))
      value = check(json->is_number_unsigned(), key, *json, "a count").get<std::uint64_t>();
  }
  /// The fields that a struct lists, as json_of() writes them.
  template <class T>
  void read_fields(T& value) const {
    T::fields(value, [this](const char* key, auto& field) { this->read(key, field); });
  }
  /// Calls `each(entry)` for the entries of a list.
  template <class Each>
  void list(const char* key, Each each) const {
    if (const Json* json = find(key)) {
      for (const Json& entry : check(json->is_array(), key, *json, "a list")) each(entry);
    }
  }
  double figure(const char* key, const Json& json) const {
    if (json.is_null()) return std::numeric_limits<double>::quiet_NaN();
    return check(json.is_number(), key, json, "a number").get<double>();
  }
  const Json& check(bool good, const char* key, const Json& json, const char* wanted) const {
    if (!good) throw std::runtime_error(place_ + key + ": is not " + wanted);
    return json;
  }

 private:
  const Json& object_;
  std::string place_;
};

}  // namespace sortie::firmware
