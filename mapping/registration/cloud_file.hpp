// SPDX-License-Identifier: BSD-3-Clause
// A cloud's cells as bytes that are kept from one robot's mission for another's.
//
// Little endian: head, cells by rising key (SightRecord), xxhash64 of all before it. Version 1 had a Gaussian
// in each cell besides, which its sums say as well; it is still read.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/cloud_config.hpp"

namespace sortie::mapping {

/// Cells that a file may have: 101 MB.
inline constexpr std::uint32_t kMostCloudCells = 1u << 20;
/// Entries of the smallest window about a cloud, 4 bytes each: 256 x 256 x 256 cells, say.
inline constexpr std::uint64_t kMostCloudWindow = std::uint64_t{1} << 24;

/// What stands before the cells. 52 bytes.
struct CloudFileHead {
  static constexpr std::uint64_t kMagic = 0x3144554f4c434f53;  ///< "SOCLOUD1"
  static constexpr std::uint32_t kVersion = 2;
  std::uint64_t magic{kMagic};
  std::uint32_t version{kVersion};
  std::uint32_t steps{kSurfelSteps};  ///< of a cell's edge, in which its sums are
  std::uint32_t sensor{};             ///< CloudSensor
  double cell_m{};                    ///< edge, [0.01, 100]
  std::uint32_t min_points{};         ///< that make a surface, [1, kMostSurfelPoints]
  double most_thickness_m{};          ///< of a flat cell, standard deviation, (0, 100]
  double most_flatness{};             ///< of its least variance over its second one, (0, 1]
  std::uint32_t cells{};              ///< at most kMostCloudCells
  SORTIE_FIELDS(magic, version, steps, sensor, cell_m, min_points, most_thickness_m, most_flatness, cells)
};

/// Why a cloud cannot be taken.
enum class CloudFileFault : std::uint8_t {
  none = 0,
  no_cloud,    ///< other bytes
  version,     ///< of another version of the format
  cells,       ///< more than kMostCloudCells
  length,      ///< cut off, or something behind it
  checksum,    ///< damaged
  sensor,      ///< none that is known
  settings,    ///< a number of the head that is out of its range
  record,      ///< a cell that cannot be
  order,       ///< one that is there twice, or out of order
  window,      ///< wider than any window (kMostCloudWindow), or than the layer's
  cell,        ///< other cells than the layer's
  min_points,  ///< other cells have a surface
  flat,        ///< other cells are flat
  room,        ///< more cells than the layer has room for
};

/// What became of reading a cloud.
struct CloudFileResult {
  CloudFileFault fault{CloudFileFault::none};
  std::uint64_t byte{};  ///< where
  const char* why{""};   ///< static; empty without a fault
  CloudSensor sensor{};
  SightConfig config;  ///< of a layer that holds just this cloud; as soon as the bytes themselves are good
  CloudFileHead head;  ///< as far as it was read
};

/// Bytes of a layer's cloud.
std::uint64_t cloud_bytes(const SightLayer& layer);
/// Writes the cloud. full: `out` is shorter than cloud_bytes(); out_of_range: settings, cells or a width that
/// no reader takes. The same cloud, the same bytes. No heap; a sort and two passes over the cells.
Status write_cloud(const SightLayer& layer, CloudSensor sensor, std::span<std::uint8_t> out);

/// Looks at all of the bytes, trusts none of them, and says what layer the cloud needs: one with its
/// settings, room for its cells and a window as wide as it is, in cells and powers of two. Such a layer then
/// takes the cloud (load_cloud()). No heap; two passes over the bytes.
CloudFileResult read_cloud_head(std::span<const std::uint8_t> bytes);

/// Puts a kept cloud in the place of the layer's, to the bit, or leaves that empty and says why not; then the
/// layer wants a prepare(). The layer has the settings of the cloud, and may have more room and a wider
/// window. No heap; three passes over the bytes.
CloudFileResult load_cloud(std::span<const std::uint8_t> bytes, SightLayer& layer);

}  // namespace sortie::mapping
