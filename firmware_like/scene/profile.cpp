// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/profile.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "firmware_like/scene/profile_text.hpp"
#include "firmware_like/scene/profile_tree.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/digest.hpp"

namespace sortie::firmware {

namespace {

std::string as_text(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

// Where a value stands: its own file, which may be that of a base, and line. What came by --set has neither.
std::string place_of(const TomlNode& node, const std::string& source) {
  if (node.line() == 0) return source;
  return (node.source() != nullptr ? *node.source() : source) + ":" + std::to_string(node.line());
}

}  // namespace

Profile::Profile(const std::string& toml, const std::string& source,
                 const std::vector<std::string>& overrides)
    : Profile(LaidScene{parse_profile(toml, source), "", source}, overrides) {}

Profile::Profile(LaidScene scene, const std::vector<std::string>& overrides)
    : tree_(std::make_unique<TomlTree>(std::move(scene.root))),
      source_(std::move(scene.source)),
      base_(std::move(scene.base)) {
  for (const std::string& assignment : overrides) apply_override(assignment);
  name_ = text("scene.name", "", "name of the scene");
  vehicle_ = text("scene.vehicle", "", "which vehicle the scene builds");
  about_ = text("scene.about", "", "one sentence for lists");
  use_ = text("scene.use", "", "what robots do in such a scene, if it is there for a real use");
  leaves_out_ = text("scene.leaves_out", "", "what the scene does without, and why");
  static_cast<void>(text("scene.unknown_keys", "refuse",
                         "ignore: keys of parts that a what-if leaves out stay where they are",
                         {"refuse", "ignore"}));
  if (name_.empty()) fail("scene.name", "a profile needs [scene] name = \"...\"");
  if (vehicle_.empty()) fail("scene.vehicle", "a profile needs [scene] vehicle = \"...\"");
}

Profile::~Profile() = default;
Profile::Profile(Profile&&) noexcept = default;
Profile& Profile::operator=(Profile&&) noexcept = default;

std::string ProfileError::one_line(std::string words) {
  for (char& c : words) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return words;
}

void Profile::apply_override(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw ProfileError("--set " + assignment + ": write key=value, for example --set mapping.voxel_m=0.2");
  }
  const std::string path = assignment.substr(0, equals);
  constexpr std::string_view kKeyCharacters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  if (path.find_first_not_of(kKeyCharacters) != std::string::npos)
    throw ProfileError("--set " + assignment + ": a key has letters, digits, _ and -, and dots between");
  const std::string value = assignment.substr(equals + 1);
  const bool has_control = std::any_of(value.begin(), value.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f;
  });
  if (has_control || !is_utf8(value))
    throw ProfileError("--set " + path +
                       ": the value is no line of UTF-8; write it without control characters");
  TomlTree parsed = TomlTree::of_text("value", value);  // a bare word is a string
  try {
    if (line_of_bare_non_ascii("value = " + value) == 0) parsed = TomlTree::parse("value = " + value);
  } catch (const TomlError&) {
    // Stays what it is.
  }
  if (const auto other = tree_->put(path, parsed, "value"))
    throw ProfileError("--set " + assignment + ": " + *other + " is not a table");
}

std::string Profile::place(const std::string& path) const {
  const TomlNode node = tree_->at_path(path);
  return (node ? place_of(node, source_) : source_) + ": " + path;
}

void Profile::fail(const std::string& path, const std::string& why) const {
  throw ProfileError(place(path) + ": " + why);
}

void Profile::check_power_of_two(const std::string& path, std::uint32_t value) const {
  if (!std::has_single_bit(value))
    fail(path, "must be a power of two: " + std::to_string(std::bit_floor(value)) + " or " +
                   std::to_string(std::bit_ceil(value)));
}

bool Profile::has(const std::string& path) const { return static_cast<bool>(tree_->at_path(path)); }

ProfileKey* Profile::declare(const std::string& path, const std::string& value, const rt::KeyRange& key,
                             const std::string& range, bool is_default) {
  for (ProfileKey& known : keys_) {
    if (known.path == path) return &known;
  }
  keys_.push_back({key, path, value, range, is_default});
  keys_.back().is_knob = knobs_.count(path) != 0;
  return &keys_.back();
}

double Profile::number(const std::string& path, const NumberSpec& spec) {
  const TomlNode node = tree_->at_path(path);
  const char* const unit = spec.unit.name;
  double value = spec.fallback;
  if (node) {
    if (!node.is_number())
      fail(path, "must be a number" + (*unit ? " in " + std::string(unit) : std::string()));
    if (!node.number()) fail(path, kTooManyDigits);
    value = *node.number();
  }
  const std::string range = as_text(spec.low) + " .. " + as_text(spec.high);
  if (!(value >= spec.low && value <= spec.high)) {
    fail(path, as_text(value) + " is outside " + range + (*unit ? " " + std::string(unit) : std::string()));
  }
  ProfileKey* key = declare(path, as_text(value), spec, range, !node);
  key->number = value;
  key->low = spec.low;  // of a key that was read before: as it is read now
  key->high = spec.high;
  return value;
}

std::int64_t Profile::integer(const std::string& path, const NumberSpec& spec) {
  const TomlNode node = tree_->at_path(path);
  if (node && !node.is_integer()) fail(path, "must be a whole number");
  return static_cast<std::int64_t>(std::llround(number(path, spec)));
}

std::optional<std::int64_t> Profile::integer_or_auto(const std::string& path, const NumberSpec& spec) {
  const TomlNode node = tree_->at_path(path);
  const bool is_auto = node.text() == "auto";
  if (node && !node.is_integer() && !is_auto) fail(path, "must be a whole number, or \"auto\"");
  std::optional<std::int64_t> value;
  if (!is_auto) value = static_cast<std::int64_t>(std::llround(number(path, spec)));
  ProfileKey* key = declare(path, "\"auto\"", {.unit = spec.unit, .meaning = spec.meaning},
                            as_text(spec.low) + " .. " + as_text(spec.high), false);
  if (key->range.find("auto") == std::string::npos) key->range += ", \"auto\"";
  return value;
}

bool Profile::flag(const std::string& path, bool fallback, const char* meaning) {
  const TomlNode node = tree_->at_path(path);
  if (node && !node.is_boolean()) fail(path, "must be true or false");
  const bool value = node.flag().value_or(fallback);
  declare(path, value ? "true" : "false", {.meaning = meaning}, "true, false", !node);
  return value;
}

std::string Profile::text(const std::string& path, const std::string& fallback, const char* meaning,
                          const std::vector<std::string>& choices) {
  const TomlNode node = tree_->at_path(path);
  if (node && !node.is_string()) fail(path, "must be a text in quotes");
  std::string value = node.text().value_or(fallback);
  std::string range;
  for (const std::string& choice : choices) range += (range.empty() ? "" : ", ") + choice;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end()) {
    fail(path, "\"" + value + "\" is not one of: " + range);
  }
  declare(path, "\"" + value + "\"", {.meaning = meaning}, range, !node);
  return value;
}

std::vector<std::string> Profile::texts(const std::string& path, const std::vector<std::string>& fallback,
                                        const char* meaning) {
  const TomlNode node = tree_->at_path(path);
  std::vector<std::string> result = fallback;
  if (node) {
    if (!node.is_list()) fail(path, "must be a list of texts in quotes");
    result.clear();
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::optional<std::string> entry = node.at(i).text();
      if (!entry) fail(path, "every entry must be a text in quotes");
      result.push_back(*entry);
    }
  }
  std::string shown;
  for (const std::string& entry : result) shown += (shown.empty() ? "\"" : ", \"") + entry + "\"";
  declare(path, "[" + shown + "]", {.meaning = meaning}, "", !node);
  return result;
}

std::vector<std::array<double, 2>> Profile::points(const std::string& path, std::size_t most,
                                                   const char* meaning) {
  const TomlNode node = tree_->at_path(path);
  std::vector<std::array<double, 2>> result;
  if (node) {
    if (!node.is_list()) fail(path, "must be a list of [x, y]");
    for (std::size_t i = 0; i < node.size(); ++i) {
      const TomlNode point = node.at(i);
      const std::optional<double> x = point.at(0).number();
      const std::optional<double> y = point.at(1).number();
      if (point.size() != 2 || !x || !y) fail(path, "every entry must be [x, y] in m");
      const std::array<double, 2> xy{*x, *y};
      if (!std::isfinite(xy[0]) || !std::isfinite(xy[1])) fail(path, "every entry must be finite");
      result.push_back(xy);
    }
    if (result.size() > most)
      fail(path, std::to_string(result.size()) + " points; at most " + std::to_string(most) + " fit");
  }
  declare(path, std::to_string(result.size()) + " points", {.unit = "m", .meaning = meaning},
          "at most " + std::to_string(most), !node);
  return result;
}

std::vector<std::string> Profile::tables(const std::string& path) const {
  struct Found {
    bool own;
    std::uint32_t line;
    std::string name;
  };
  std::vector<Found> found;
  const TomlNode table = path.empty() ? tree_->root() : tree_->at_path(path);
  for (const auto& [key, value] : table.entries()) {
    if (value.is_table())
      found.push_back({value.source() != nullptr && *value.source() == source_, value.line(), key});
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return std::tie(a.own, a.line) < std::tie(b.own, b.line);
  });
  std::vector<std::string> names;
  names.reserve(found.size());
  for (Found& entry : found) names.push_back(std::move(entry.name));
  return names;
}

void Profile::refuse_unknown_keys(const std::string& below, const std::string& except) const {
  if (tree_->at_path("scene.unknown_keys").text() == "ignore") return;
  std::set<std::string> known;
  for (const ProfileKey& key : keys_) known.insert(key.path);
  const auto walk = [&](const auto& self, const TomlNode& table, const std::string& prefix) -> void {
    for (const auto& [key, value] : table.entries()) {
      const std::string path = prefix + key;
      if (value.is_table()) {
        self(self, value, path + ".");
        continue;
      }
      if (known.count(path) != 0 || path.rfind(below.empty() ? "" : below + ".", 0) != 0) continue;
      if (!except.empty() && path.rfind(except + ".", 0) == 0) continue;
      const std::vector<std::string> meant = nearest_words(path, {known.begin(), known.end()}, 1);
      throw ProfileError(place_of(value, source_) + ": unknown key " + path +
                         (meant.empty()
                              ? "; remove it, or see `sortie scenes --keys` for what this vehicle knows"
                              : "; did you mean " + meant.front() + "?"));
    }
  };
  walk(walk, tree_->root(), "");
}

std::string Profile::canonical() const { return tree_->canonical() + "\n"; }

std::uint64_t Profile::hash() const {
  const std::string text = canonical();
  return rt::digest_bytes(text.data(), text.size());
}

Profile load_scene(const std::string& scene, const std::vector<std::string>& overrides) {
  return Profile(read_with_bases(scene), overrides);
}

}  // namespace sortie::firmware
