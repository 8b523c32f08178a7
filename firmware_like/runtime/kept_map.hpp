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

  /// `more`, and what a profile says of a run with this map: its name and digest, so that the log's header
  /// has both.
  std::vector<std::string> overrides(std::vector<std::string> more) const;
};

/// Reads a file of `sortie export surfels` or `export cloud`. Throws InputError where it cannot be read or is
/// longer than any map.
KeptMap read_kept_map(const std::string& path);

}  // namespace sortie::firmware
