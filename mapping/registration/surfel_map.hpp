// SPDX-License-Identifier: BSD-3-Clause
// A map of surfaces as bytes that are kept from one run to another.
//
// Little endian: head, the layers' surfels each by rising key (SurfelRecord), xxhash64 of all before it.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/scan_registration.hpp"

namespace sortie::mapping {

/// What stands before the surfels. 48 bytes.
struct SurfelMapHead {
  static constexpr std::uint64_t kMagic = 0x4c45465255534f53;  ///< "SOSURFEL"
  static constexpr std::uint32_t kVersion = 2;                 ///< 1: a surface had one side
  static constexpr std::uint32_t kInPlane = 102;  ///< of a map in the plane (RegistrationConfig::planar)
  std::uint64_t magic{kMagic};
  std::uint32_t version{kVersion};
  std::uint32_t steps{kSurfelSteps};  ///< of a cell's edge, in which its sums are
  double cell_m{};                    ///< of the finest layer
  std::uint32_t min_points{};
  std::uint32_t memory_points{};
  std::uint32_t surfels[kSurfelLayers]{};
  std::uint32_t layers{kSurfelLayers};
  SORTIE_FIELDS(magic, version, steps, cell_m, min_points, memory_points, surfels, layers)
};

/// Why a map cannot be taken.
enum class SurfelMapFault : std::uint8_t {
  none = 0,
  no_map,         ///< other bytes
  version,        ///< of another version of the format
  length,         ///< cut off, or something behind it
  checksum,       ///< damaged
  planar,         ///< of a plane for a registration in space, or the other way round
  cell,           ///< other cells than the registration's
  min_points,     ///< other cells have a surface
  memory_points,  ///< cells fade at another number
  surfel,         ///< one that cannot be: `why`
  order,          ///< one that is there twice, or out of order
  room,           ///< more surfels than there is room for: `needed` of the finest layer
  window,         ///< wider than half the window: `needed` cells of the finest layer along x and y
  height,         ///< the same upwards
};

/// What became of loading a map.
struct SurfelMapResult {
  SurfelMapFault fault{SurfelMapFault::none};
  int layer{};
  std::uint64_t byte{};    ///< where, of a surfel
  std::uint32_t needed{};  ///< by room, window and height
  const char* why{""};     ///< static
  SurfelMapHead head;      ///< as far as it was read
};

/// Bytes of a registration's map.
std::uint64_t surfel_map_bytes(const ScanRegistration& registration);
/// Writes the map; full where `out` is shorter than surfel_map_bytes(). The same map, the same bytes.
Status write_surfel_map(const ScanRegistration& registration, std::span<std::uint8_t> out);

/// Puts a kept map in the place of the registration's, to the bit, or leaves that empty and says why not.
/// Nothing in the bytes is trusted. A map fits whose surfels all have room in half the window: then the robot
/// may stand anywhere on it, and nothing of it is given back. No heap; a few passes over the bytes.
SurfelMapResult load_surfel_map(std::span<const std::uint8_t> bytes, ScanRegistration& registration);

}  // namespace sortie::mapping
