// SPDX-License-Identifier: BSD-3-Clause
// A map in a file, as a run begins with it: surfaces, a cloud, targets, or images.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sortie::firmware {

/// The file's bytes, which nobody has looked at yet.
struct KeptMap {
  std::string option;  ///< it was given with: "--map", "--targets" or "--images"
  std::string path;
  std::string name;    ///< the path's last part, with letters, digits, '.', '_' and '-' alone
  std::string digest;  ///< of all bytes
  std::string table;   ///< of the profile, whose part reads it: "locate", "join" (a cloud), "recognise"
                       ///< (targets), "recognise_images"
  std::vector<std::uint8_t> bytes;
  /// "map of surfaces", "cloud", "list of targets", "list of images".
  const char* kind() const;
};

/// What a run may begin with. Empty paths: without.
struct KeptMapPaths {
  std::string map;      ///< of `sortie export surfels` or `export cloud`
  std::string targets;  ///< of `sortie export targets`
  std::string images;   ///< of `sortie export images`

  /// Calls `visit(name, path)` of each; its option is "--" and the name.
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit("map", self.map);
    visit("targets", self.targets);
    visit("images", self.images);
  }
};

/// Reads what is given. Throws InputError where a file cannot be read, is longer than any map, or is of
/// another kind than its option says.
std::vector<KeptMap> read_kept_maps(const KeptMapPaths& paths);

/// `more`, and the maps' names and digests as a profile has them, so that they stand in the log's header.
std::vector<std::string> overrides_of(std::span<const KeptMap> maps, std::vector<std::string> more);

}  // namespace sortie::firmware
