// SPDX-License-Identifier: BSD-3-Clause
// The only file that includes the JSON library: it reads and writes texts, numbers and escapes among them.
#include <istream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ostream>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

namespace {

using Library = nlohmann::ordered_json;

Library to_library(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_float()) return json.get<double>();
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_string()) return json.get<std::string>();
  if (json.is_array()) {
    Library::array_t array;
    array.reserve(json.size());
    for (const Json& element : json) array.push_back(to_library(element));
    return array;
  }
  if (json.is_null()) return nullptr;
  Library::object_t object;
  object.reserve(json.size());
  // Keys are unique already: the map's own emplace would look through all of them each time.
  Library::object_t::Container& members = object;
  for (const auto& [key, value] : json.items()) members.emplace_back(key, to_library(value));
  return object;
}

/// Builds a value from what the library's parser finds.
class JsonBuilder {
 public:
  explicit JsonBuilder(Json& root) : open_{&root} {}
  const std::string& fault() const { return fault_; }

  bool null() { return put(nullptr) != nullptr; }
  bool boolean(bool value) { return put(value) != nullptr; }
  bool number_integer(std::int64_t value) { return put(value) != nullptr; }
  bool number_unsigned(std::uint64_t value) { return put(value) != nullptr; }
  bool number_float(double value, const std::string&) { return put(value) != nullptr; }
  bool string(std::string& value) { return put(std::move(value)) != nullptr; }
  bool binary(Library::binary_t&) { return false; }  // not in texts
  bool key(std::string& name) {
    member_ = &(*open_.back())[name];
    return true;
  }
  bool start_object(std::size_t) { return start(Json::object()); }
  bool start_array(std::size_t) { return start(Json::array()); }
  bool end_object() { return end(); }
  bool end_array() { return end(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& error) {
    fault_ = error.what();
    return false;
  }

 private:
  // The value's place: an element, a member, or the root, which is the first that is open.
  Json* put(Json value) {
    Json* place = open_.back();
    if (place->is_array()) {
      place->push_back(std::move(value));
      return &place->back();
    }
    if (place->is_object()) place = member_;
    *place = std::move(value);
    return place;
  }
  bool start(Json value) {
    if (open_.size() > Json::kMostDepth) {
      fault_ = "JSON: more than " + std::to_string(Json::kMostDepth) + " arrays and objects in one another";
      return false;
    }
    open_.push_back(put(std::move(value)));
    return true;
  }
  bool end() {
    open_.pop_back();
    return true;
  }

  // A container grows only while it is the innermost, so that the places stay.
  std::vector<Json*> open_;
  Json* member_{};
  std::string fault_;
};

/// Empty where the text was good.
std::string read_json(std::string_view text, Json& json) {
  JsonBuilder builder(json);
  return Library::sax_parse(text.begin(), text.end(), &builder) ? std::string() : builder.fault();
}

}  // namespace

Json Json::parse(std::string_view text) {
  Json json;
  if (const std::string fault = read_json(text, json); !fault.empty()) throw JsonError(fault);
  return json;
}

Json Json::parse_or_null(std::string_view text) {
  Json json;
  return read_json(text, json).empty() ? json : Json();
}

Json Json::parse_or_null(std::istream& in) {
  return parse_or_null(std::string(std::istreambuf_iterator<char>(in), {}));
}

std::string Json::dump(int indent) const {
  return to_library(*this).dump(indent, ' ', false, Library::error_handler_t::replace);
}

std::ostream& operator<<(std::ostream& out, const Json& json) { return out << json.dump(); }

}  // namespace sortie::firmware
