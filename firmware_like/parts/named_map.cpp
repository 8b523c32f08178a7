// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/named_map.hpp"

namespace sortie::firmware {

const KeptMap* named_map(VehicleBuilder& builder, const std::string& table) {
  Profile& profile = builder.profile();
  const std::string key = table + ".map";
  const std::string name = profile.text(key, "", "the map that the run begins with; --map FILE writes it");
  const std::string digest = profile.text(key + "_digest", "", "its digest; --map FILE writes it");
  const KeptMap* map = builder.kept_map(table);
  if (map == nullptr) {
    if (!name.empty() || !digest.empty())
      profile.fail(key, "begins with the map " + name + " (digest " + digest + "); give it with --map FILE");
    return nullptr;
  }
  if (map->digest != digest)
    profile.fail(key, "begins with the map " + name + " (digest " + digest + "), and --map " + map->path +
                          " is another one (digest " + map->digest + ")");
  return map;
}

}  // namespace sortie::firmware
