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

/// Files that are no map of their own: what is recognised on one.
struct KeptList {
  std::string_view option, magic, table, kind, what;
  std::string make() const { return "make it with `sortie export " + std::string(what) + " LOG -o FILE`"; }
};
constexpr KeptList kLists[] = {{"--targets", "SOTARGET", "recognise", "list of targets", "targets"},
                               {"--images", "SOIMAGES", "recognise_images", "list of images", "images"}};

KeptMap read_kept_map(const std::string& option, const std::string& path) {
  const KeptList* list = nullptr;
  for (const KeptList& one : kLists) list = option == one.option ? &one : list;
  const std::string make = list != nullptr ? list->make() : kMakeMap;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || !std::filesystem::is_regular_file(path, error))
    throw InputError(option + " " + path + ": cannot be read; " + make);
  if (size > kMostBytes) throw InputError(option + " " + path + ": is longer than any map; " + make);
  KeptMap map{option, path, plain_name(path), "", list != nullptr ? std::string(list->table) : "locate", {}};
  map.bytes.resize(static_cast<std::size_t>(size));
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(map.bytes.data()), static_cast<std::streamsize>(size));
  if (!in) throw InputError(option + " " + path + ": cannot be read to its end");
  const auto begins_with = [&map](std::string_view magic) {
    return map.bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), map.bytes.begin());
  };
  if (list == nullptr && begins_with("SOCLOUD")) map.table = "join";
  const KeptList* held = nullptr;
  for (const KeptList& one : kLists) held = begins_with(one.magic) ? &one : held;
  if (held != list) {
    const std::string what(held != nullptr ? held->what : list->what);
    const std::string why = held != nullptr ? ": holds " + what + ": give it with --" + what + ", or "
                                            : ": holds no " + what + "; ";
    throw InputError(option + " " + path + why + make, 2);
  }
  map.digest = hex(rt::digest_bytes(map.bytes.data(), map.bytes.size()));
  return map;
}

}  // namespace

const char* KeptMap::kind() const {
  if (table == "join") return "cloud";
  for (const KeptList& one : kLists)
    if (table == one.table) return one.kind.data();
  return "map of surfaces";
}

std::vector<KeptMap> read_kept_maps(const KeptMapPaths& paths) {
  std::vector<KeptMap> maps;
  KeptMapPaths::fields(paths, [&maps](const char* name, const std::string& path) {
    if (!path.empty()) maps.push_back(read_kept_map(std::string("--") + name, path));
  });
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
