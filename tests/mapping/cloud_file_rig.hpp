// SPDX-License-Identifier: BSD-3-Clause
// Small kept clouds: their bytes, changed behind a right checksum, and what makes a cloud a sound one.
#pragma once

#include <catch2/catch.hpp>

#include "mapping/registration/cloud_file.hpp"
#include "rt/digest.hpp"
#include "tests/mapping/cloud_trials.hpp"

namespace sortie::tests {

using CloudBytes = std::vector<std::uint8_t>;

inline constexpr std::size_t kCloudHeadBytes = 52;
inline constexpr std::size_t kCloudRecordBytes = 96;
inline constexpr std::size_t kFromByte = 72;  // of a record

inline CloudBytes cloud_of(const mapping::SightLayer& layer,
                           mapping::CloudSensor sensor = mapping::CloudSensor::laser) {
  CloudBytes bytes(static_cast<std::size_t>(mapping::cloud_bytes(layer)));
  REQUIRE(mapping::write_cloud(layer, sensor, bytes) == Status::ok);
  return bytes;
}

/// With a check sum that fits, whatever was changed.
inline CloudBytes checked_anew(CloudBytes bytes) {
  const std::uint64_t check = rt::digest_bytes(bytes.data(), bytes.size() - 8);
  for (std::size_t i = 0; i < 8; ++i)
    bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(check >> (8 * i));
  return bytes;
}

template <class T>
CloudBytes with(CloudBytes bytes, std::size_t at, T value) {
  rt::Archive archive = rt::Archive::writing(std::span(bytes).subspan(at));
  archive.value(value);
  REQUIRE(archive.status() == Status::ok);
  return checked_anew(bytes);
}

/// Same cells, to the bit, found at the same places.
inline void check_same_cloud(mapping::SightLayer& a, mapping::SightLayer& b) {
  REQUIRE((cloud_of(a) == cloud_of(b)));
  a.prepare(), b.prepare();
  REQUIRE(a.cells().size() == b.cells().size());
  for (std::size_t i = 0; i < a.cells().size(); ++i) {
    const mapping::SightCell& p = a.cells()[i];
    const mapping::SightCell& q = b.cells()[i];
    REQUIRE(rt::digest_of(p.mean_m) == rt::digest_of(q.mean_m));
    REQUIRE(rt::digest_of(p.normal) == rt::digest_of(q.normal));
    REQUIRE(rt::digest_of(p.from_m) == rt::digest_of(q.from_m));
    REQUIRE(p.sigma_m == q.sigma_m);
    REQUIRE(a.at(p.mean_m) == &p);
    REQUIRE(b.at(p.mean_m) == &q);
  }
  std::vector<std::uint64_t> first, second;
  a.for_each_plane_cell(a.by_key(),
                        [&](const mapping::PlaneCell& cell) { first.push_back(rt::digest_of(cell)); });
  b.for_each_plane_cell(b.by_key(),
                        [&](const mapping::PlaneCell& cell) { second.push_back(rt::digest_of(cell)); });
  REQUIRE(first.size() == a.size());
  REQUIRE(first == second);
}

/// Finite, in their cells, and such as planes are grown from.
inline void check_sound(mapping::SightLayer& layer) {
  layer.prepare();
  for (const mapping::SightCell& cell : layer.cells()) {
    REQUIRE((rt::is_finite(cell.mean_m) && rt::is_finite(cell.from_m) && std::isfinite(cell.sigma_m)));
    REQUIRE(std::fabs(rt::norm(cell.normal) - 1.0) < 1e-3);
  }
  OwnedGrowing owned(mapping::growing_config(mapping::CloudSensor::laser), 256, 16);
  layer.for_each_plane_cell(layer.by_key(), [&](const mapping::PlaneCell& cell) {
    REQUIRE(owned.growing.set_cell(cell) == Status::ok);
    for (const float part : cell.mean_m)
      REQUIRE(std::fabs(static_cast<double>(part)) <= 0.5001 * layer.cell_m());
  });
}

/// A corner of a room: three walls.
inline std::vector<SeenPoint> small_cloud(std::uint32_t seed) {
  WorldRandom random(seed);
  std::vector<SeenPoint> out;
  for (int wall = 0; wall < 3; ++wall) {
    for (int i = 0; i < 200; ++i) {
      const double a = random.between(-0.3, 0.7), b = random.between(-0.3, 0.7), c = 0.005 * random.normal();
      const rt::Vector3 at = wall == 0   ? rt::Vector3{a, b, 0.9 + c}
                             : wall == 1 ? rt::Vector3{a, 0.9 + c, b}
                                         : rt::Vector3{0.9 + c, a, b};
      out.push_back({at, {0.1, 0.2, 0.3}});
    }
  }
  return out;
}

inline mapping::SightConfig small_layer() {
  mapping::SightConfig config;
  config.cells = 64;
  config.window_cells = 16;
  config.window_cells_up = 8;
  return config;
}

}  // namespace sortie::tests
