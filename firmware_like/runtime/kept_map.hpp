// SPDX-License-Identifier: BSD-3-Clause
// A map in a file, as a run begins with it: surfaces, or a cloud.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sortie::firmware {

/// The file's bytes, which nobody has looked at yet.
struct KeptMap {
  std::string path;
  std::string name;    ///< the path's last part, with letters, digits, '.', '_' and '-' alone
  std::string digest;  ///< of all bytes
  std::string table;   ///< of the profile, whose part reads such a map: "locate", or "join" for a cloud
  std::vector<std::uint8_t> bytes;

  /// `more`, and this map's name and digest as a profile has them, so that they stand in the log's header.
  std::vector<std::string> overrides(std::vector<std::string> more) const;
};

/// Reads a file of `sortie export surfels` or `export cloud`. Throws InputError where it cannot be read or is
/// longer than any map.
KeptMap read_kept_map(const std::string& path);

}  // namespace sortie::firmware
