// SPDX-License-Identifier: BSD-3-Clause
// The surfaces of a map as bits, for the search of a place on it.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/place_tiles.hpp"
#include "mapping/registration/registration_config.hpp"
#include "mapping/registration/surfel_layer.hpp"
#include "rt/arena.hpp"

namespace sortie::mapping {

/// Where a pose of the search stands: whole steps of PlaceMap::kStep voxels, and of a turn.
struct PlaceCell {
  std::int32_t at[3]{};
  std::int32_t turn{};
  SORTIE_FIELDS(at, turn)
};

/// The voxels of a layer's surfaces, half a cell each, and the same for blocks of poses. A return counts
/// once where a surface is within half a voxel of its voxel along each axis: just as far as the nearest pose
/// of the search is from any; and once more where the surface goes through its voxel. Built at set-up from a
/// map that then stays what it is.
class PlaceMap {
 public:
  static constexpr std::int32_t kStep = 1;  ///< voxels from pose to pose
  static constexpr std::int32_t kPart = 2;  ///< poses of a part along each axis
  static constexpr std::int32_t kNode = 4;  ///< poses of a node along each axis
  static constexpr std::int32_t kTop = 4;   ///< nodes of a top along each axis

  /// Room for any map that fits into half the window of a registration, and has at most `most_tops`.
  PlaceMap(const RegistrationMemory& memory, std::uint32_t most_tops, rt::Arena& arena);

  /// Takes the surfaces of a layer. False, and the map is empty: there are none, or they are wider than half
  /// the window, or have too many tops. Not for the real-time path: some ten passes over the voxels.
  bool build(const SurfelLayer& layer);

  bool empty() const { return tops() == 0; }
  double voxel_m() const { return voxel_m_; }
  /// Along an axis.
  std::int32_t tops(int axis) const { return tops_[axis]; }
  std::int32_t tops() const { return tops_[0] * tops_[1] * tops_[2]; }
  /// What the surfaces that were built last need, whether or not there was room for them; 0: there are none.
  std::uint64_t wanted_tops() const { return wanted_tops_; }
  /// The sensor of a pose.
  rt::Vector3 position_m(const PlaceCell& cell) const;

  /// For the poses themselves: a return counts where its voxel is occupied.
  const PlaceTiles& poses() const { return poses_; }
  /// For parts of 2 x 2 x 2 poses: where it may be for any of them.
  const PlaceTiles& parts() const { return parts_; }
  /// For nodes: where it may be for any pose of the node.
  const PlaceTiles& nodes() const { return nodes_; }

 private:
  void draw(const SurfelLayer& layer, std::int32_t steps);
  void draw(const Surfel& surfel, const SurfelCell& cell, std::int32_t steps);
  void spread(int axis, std::int32_t by);
  void copy_all(int kind);
  void copy(int kind, PlaceTiles& tiles) const;
  std::size_t row(std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(row_words_);
  }

  std::uint32_t most_tops_;
  std::uint64_t wanted_tops_{};
  double voxel_m_{};
  rt::Vector3 origin_m_;    ///< corner of the first voxel of the map
  SurfelCell first_;        ///< its cell
  std::int32_t size_[3]{};  ///< voxels, with margins
  std::int32_t row_words_{};
  std::int32_t tops_[3]{};
  std::span<std::uint64_t> bits_;  ///< rows along x; scratch of build()
  PlaceTiles poses_;
  PlaceTiles parts_;
  PlaceTiles nodes_;
};

}  // namespace sortie::mapping
