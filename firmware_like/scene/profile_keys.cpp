// SPDX-License-Identifier: BSD-3-Clause
// Reading what a config struct lists.
#include <algorithm>
#include <span>

#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

std::string key_path(const std::string& table, const std::string& name) {
  return name.find('.') == std::string::npos ? table + "." + name : name;
}

bool Profile::read_key(const std::string& path, const rt::KeySpec& spec, rt::KeyKind kind, double& written) {
  if ((spec.marks & rt::kKnob) != 0) knob(path);
  if (kind == rt::KeyKind::whole) {
    written = static_cast<double>(integer(path, {written, spec}));
  } else if (kind == rt::KeyKind::flag) {
    written = flag(path, written != 0.0, spec.meaning) ? 1 : 0;
  } else if (kind == rt::KeyKind::choice) {
    const auto names = std::span(spec.choices, spec.count);
    std::vector<std::string> known;
    for (const rt::KeyChoice& choice : names) known.emplace_back(choice.name);
    const auto now = std::ranges::find(names, static_cast<int>(written), &rt::KeyChoice::value);
    const std::string said = text(path, now == names.end() ? "" : now->name, spec.meaning, known);
    written = names[static_cast<std::size_t>(std::ranges::find(known, said) - known.begin())].value;
  } else {
    written = number(path, {written, spec});
  }
  return has(path);
}

void Profile::read_point(const std::string& path, const rt::KeySpec& spec, rt::Vector3& point) {
  const std::vector<double> read = numbers(path, {point.x, point.y, point.z}, {0, spec});
  point = {read[0], read[1], read[2]};
}

void Profile::knob(const std::string& path) {
  knobs_.insert(path);
  for (ProfileKey& key : keys_) key.is_knob = key.is_knob || key.path == path;
}

}  // namespace sortie::firmware
