// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/kept_map.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/digest.hpp"

namespace sortie::firmware {
namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{512} << 20;
constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";

// It goes into a line of TOML.
std::string plain_name(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  for (char& c : name)
    if (kPlain.find(c) == std::string_view::npos) c = '_';
  return name;
}

constexpr const char* kMakeMap =
    "make it with `sortie export surfels LOG -o FILE` or `sortie export cloud LOG -o FILE`";
constexpr const char* kMakeTargets = "make it with `sortie export targets LOG -o FILE`";

KeptMap read_kept_map(const std::string& option, const std::string& path) {
  const bool is_targets = option == "--targets";
  const std::string make = is_targets ? kMakeTargets : kMakeMap;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || !std::filesystem::is_regular_file(path, error))
    throw InputError(option + " " + path + ": cannot be read; " + make);
  if (size > kMostBytes) throw InputError(option + " " + path + ": is longer than any map; " + make);
  KeptMap map{option, path, plain_name(path), "", is_targets ? "recognise" : "locate", {}};
  map.bytes.resize(static_cast<std::size_t>(size));
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(map.bytes.data()), static_cast<std::streamsize>(size));
  if (!in) throw InputError(option + " " + path + ": cannot be read to its end");
  const auto begins_with = [&map](std::string_view magic) {
    return map.bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), map.bytes.begin());
  };
  if (!is_targets && begins_with("SOCLOUD")) map.table = "join";
  if (begins_with("SOTARGET") != is_targets)
    throw InputError(
        option + " " + path +
            (is_targets ? ": holds no targets; " : ": holds targets: give it with --targets, or ") + make,
        2);
  map.digest = hex(rt::digest_bytes(map.bytes.data(), map.bytes.size()));
  return map;
}

}  // namespace

const char* KeptMap::kind() const {
  if (table == "join") return "cloud";
  return table == "recognise" ? "list of targets" : "map of surfaces";
}

std::vector<KeptMap> read_kept_maps(const KeptMapPaths& paths) {
  std::vector<KeptMap> maps;
  if (!paths.map.empty()) maps.push_back(read_kept_map("--map", paths.map));
  if (!paths.targets.empty()) maps.push_back(read_kept_map("--targets", paths.targets));
  return maps;
}

std::vector<std::string> overrides_of(std::span<const KeptMap> maps, std::vector<std::string> more) {
  for (const KeptMap& map : maps) {
    more.insert(more.end(),
                {map.table + ".map=\"" + map.name + "\"", map.table + ".map_digest=\"" + map.digest + "\""});
  }
  return more;
}

}  // namespace sortie::firmware
