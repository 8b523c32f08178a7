// SPDX-License-Identifier: BSD-3-Clause
// Maps of surfaces that a run left, as files for another one.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"
#include "mapping/registration/surfel_map.hpp"
#include "tests/firmware_like/located_rig.hpp"

namespace sortie::testing {

inline std::vector<std::uint8_t> map_bytes(const firmware::Runtime& runtime) {
  const mapping::ScanRegistration* map = runtime.vehicle().surfels();
  REQUIRE(map != nullptr);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::surfel_map_bytes(*map)));
  REQUIRE(mapping::write_surfel_map(*map, bytes) == Status::ok);
  return bytes;
}

/// Writes the map at the end of a log; gives its bytes.
inline std::vector<std::uint8_t> keep_map(const std::string& log, const std::string& path) {
  std::vector<std::uint8_t> bytes = map_bytes(*replay_log(log, {}).runtime);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

}  // namespace sortie::testing
