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

}  // namespace

std::vector<std::string> KeptMap::overrides(std::vector<std::string> more) const {
  more.insert(more.end(), {table + ".map=\"" + name + "\"", table + ".map_digest=\"" + digest + "\""});
  return more;
}

KeptMap read_kept_map(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || !std::filesystem::is_regular_file(path, error))
    throw InputError("--map " + path +
                     ": cannot be read; make it with `sortie export surfels LOG -o FILE`"
                     " or `sortie export cloud LOG -o FILE`");
  if (size > kMostBytes)
    throw InputError(
        "--map " + path +
        ": is longer than any map; make one with `sortie export surfels LOG` or `sortie export cloud LOG`");
  KeptMap map{path, plain_name(path), "", "locate", {}};
  map.bytes.resize(static_cast<std::size_t>(size));
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(map.bytes.data()), static_cast<std::streamsize>(size));
  if (!in) throw InputError("--map " + path + ": cannot be read to its end");
  constexpr std::string_view kCloud = "SOCLOUD";
  if (map.bytes.size() >= kCloud.size() && std::equal(kCloud.begin(), kCloud.end(), map.bytes.begin()))
    map.table = "join";
  map.digest = hex(rt::digest_bytes(map.bytes.data(), map.bytes.size()));
  return map;
}

}  // namespace sortie::firmware
