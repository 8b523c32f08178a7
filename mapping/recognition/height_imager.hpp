// SPDX-License-Identifier: BSD-3-Clause
// Makes the height image of a local map, in slices.
#pragma once

#include <cstdint>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/recognition/height_image.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// How far an imager is.
enum class ImageStage : std::uint8_t {
  idle,       ///< nothing was begun
  levelling,  ///< first visit of the voxels: how high the floor is
  drawing,    ///< second visit
  drawn,      ///< the image can be read
  floorless   ///< there is no floor below the sensor
};

/// Visits a grid's active voxels twice. The floor is where most voxels are, of two layers of 5 cm, up to 3 m
/// below the sensor's block and 0.4 m above its foot, within 6.4 m along x and y; ties: the lower one. An
/// image of a slope has what lies above and below that floor as structure. Scans that come between two slices
/// change what is visited later: give it enough units, and none does. What it puts out depends on the grid
/// alone, as it was when each block was visited. A unit is a voxel, or a block that is passed over; 3 to 4
/// ns. Memory: 7 kB. No heap.
class HeightImager {
 public:
  static constexpr std::int32_t kReachBlocks = 511;  ///< what is farther away is left out
  static constexpr std::int32_t kLeastFloor = 64;    ///< voxels

  void begin(const RollingGrid& grid);
  /// Goes on until the image is drawn or `units` are used, at most a block beyond. Gives what was used.
  std::uint32_t run(const RollingGrid& grid, std::uint32_t units);

  ImageStage stage() const { return stage_; }
  bool is_working() const { return stage_ == ImageStage::levelling || stage_ == ImageStage::drawing; }
  /// Once drawn; its middle in the grid's frame.
  const HeightImage& image() const { return image_; }

  void archive(rt::Archive& archive);

 private:
  static constexpr std::int32_t kDeepestCm = -300;
  static constexpr std::int32_t kLayerCm = 5;
  static constexpr std::size_t kLayers = 68;

  void visit(const RollingGrid& grid, const Block& block);
  void draw(std::int64_t x, std::int64_t y, std::int32_t height_cm);
  void level();

  HeightImage image_;
  ImageStage stage_{ImageStage::idle};
  std::uint32_t at_{};               ///< block that is next
  BlockAt anchor_;                   ///< its corner is the middle
  std::int64_t cells_of_step_{};     ///< a step is 1/256 of a voxel's edge; in parts of 2^32
  std::int64_t cm_of_step_{};        ///< the same
  std::uint32_t voxels_[kLayers]{};  ///< by height
  std::int64_t heights_[kLayers]{};  ///< sums of these, cm above the anchor
  std::int32_t floor_cm_{};          ///< above the anchor
};

}  // namespace sortie::mapping
