// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/height_imager.hpp"

#include <algorithm>
#include <cstdlib>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {

constexpr std::int32_t kImageStepsOfBlock = 1024;
constexpr double kParts = 4294967296.0;  // 2^32
constexpr std::int64_t kNearCells = 32;

std::int64_t nearest(double value) { return static_cast<std::int64_t>(rt::floor(value + 0.5)); }

}  // namespace

void HeightImager::begin(const RollingGrid& grid) {
  const double step_m = grid.config().voxel_size_m / 256.0;
  cells_of_step_ = nearest(100.0 * step_m / HeightImage::kCellCm * kParts);
  cm_of_step_ = nearest(100.0 * step_m * kParts);
  anchor_ = grid.centre();
  image_ = {};
  std::fill(std::begin(voxels_), std::end(voxels_), 0u);
  std::fill(std::begin(heights_), std::end(heights_), std::int64_t{0});
  floor_cm_ = 0;
  at_ = 0;
  stage_ = ImageStage::levelling;
}

std::uint32_t HeightImager::run(const RollingGrid& grid, std::uint32_t units) {
  std::uint32_t used = 0;
  while (is_working() && used < units) {
    for (; used < units && at_ < grid.block_numbers(); ++at_) {
      const Block& block = grid.block(static_cast<BlockIndex>(at_));
      ++used;
      if (!block.in_use()) continue;
      used += bits_in(block.active);
      visit(grid, block);
    }
    if (at_ < grid.block_numbers()) break;
    at_ = 0;
    if (stage_ == ImageStage::levelling) {
      level();
    } else {
      stage_ = ImageStage::drawn;
    }
  }
  return used;
}

void HeightImager::visit(const RollingGrid& grid, const Block& block) {
  const BlockAt at = BlockAt::from_key(block.key);
  const std::int32_t off[3] = {at.x - anchor_.x, at.y - anchor_.y, at.z - anchor_.z};
  if (std::max({std::abs(off[0]), std::abs(off[1]), std::abs(off[2])}) > kReachBlocks) return;
  for (std::uint64_t rest = block.active; rest != 0; rest = without_lowest(rest)) {
    const unsigned cell = lowest(rest);
    const Centroid& c = grid.voxel(block, cell);
    const auto steps = [](std::int32_t blocks, unsigned in_block, std::uint16_t offset) {
      return std::int64_t{kImageStepsOfBlock} * blocks + (in_block << 8 | static_cast<unsigned>(offset) >> 8);
    };
    // Shifts of whole numbers below zero go down, as a floor does.
    draw(steps(off[0], cell & 3, c.x) * cells_of_step_ >> 32,
         steps(off[1], cell >> 2 & 3, c.y) * cells_of_step_ >> 32,
         static_cast<std::int32_t>(steps(off[2], cell >> 4, c.z) * cm_of_step_ >> 32));
  }
}

/// A voxel by its column, counted from the middle, and its height above the anchor.
void HeightImager::draw(std::int64_t x, std::int64_t y, std::int32_t height_cm) {
  if (stage_ == ImageStage::levelling) {
    if (x < -kNearCells || y < -kNearCells || x >= kNearCells || y >= kNearCells) return;
    const std::int32_t above = height_cm - kDeepestCm;
    if (above < 0 || above >= kLayerCm * static_cast<std::int32_t>(kLayers)) return;
    const auto layer = static_cast<std::size_t>(above / kLayerCm);
    ++voxels_[layer];
    heights_[layer] += height_cm;
    return;
  }
  const std::int64_t column = x + ImagePlane::kHalf, row = y + ImagePlane::kHalf;
  if (column < 0 || row < 0 || column >= ImagePlane::kCells || row >= ImagePlane::kCells) return;
  const auto cx = static_cast<std::int32_t>(column), cy = static_cast<std::int32_t>(row);
  const std::int32_t above = height_cm - floor_cm_;
  if (above >= -HeightImage::kFloorCm && above <= HeightImage::kFloorCm) image_.floor.set(cx, cy);
  if (above >= HeightImage::kLowCm && above < HeightImage::kHighCm) image_.low.set(cx, cy);
  if (above >= HeightImage::kHighCm && above < HeightImage::kTopCm) image_.high.set(cx, cy);
}

void HeightImager::level() {
  std::size_t best = 0;
  for (std::size_t i = 1; i + 1 < kLayers; ++i) {
    if (voxels_[i] + voxels_[i + 1] > voxels_[best] + voxels_[best + 1]) best = i;
  }
  const std::int64_t count = std::int64_t{voxels_[best]} + voxels_[best + 1];
  if (count < kLeastFloor) {
    stage_ = ImageStage::floorless;
    return;
  }
  const std::int64_t sum = heights_[best] + heights_[best + 1] - std::int64_t{kDeepestCm} * count;
  floor_cm_ = static_cast<std::int32_t>((sum + count / 2) / count) + kDeepestCm;
  const double cm_of_block = 1024.0 * static_cast<double>(cm_of_step_) / kParts;
  image_.middle = {static_cast<std::int32_t>(nearest(cm_of_block * anchor_.x)),
                   static_cast<std::int32_t>(nearest(cm_of_block * anchor_.y)),
                   static_cast<std::int32_t>(nearest(cm_of_block * anchor_.z) + floor_cm_)};
  stage_ = ImageStage::drawing;
}

void HeightImager::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "height imager")
      .state(image_, stage_, at_, anchor_, cells_of_step_, cm_of_step_, voxels_, heights_, floor_cm_);
  if (!archive.is_reading()) return;
  bool can_be = stage_ <= ImageStage::floorless && cells_of_step_ >= 0 && cm_of_step_ >= 0 &&
                cells_of_step_ <= std::int64_t{1} << 33 && cm_of_step_ <= std::int64_t{1} << 35 &&
                std::abs(std::int64_t{floor_cm_}) <= -kDeepestCm;
  for (const std::int32_t part : {anchor_.x, anchor_.y, anchor_.z})
    can_be = can_be && part >= -BlockAt::kLimit && part < BlockAt::kLimit;
  for (std::size_t i = 0; i < kLayers; ++i) {
    const std::int64_t most = std::int64_t{-kDeepestCm} * voxels_[i];
    can_be = can_be && heights_[i] >= -most && heights_[i] <= most;
  }
  if (can_be) return;
  archive.fail(Status::malformed, "an image that cannot be");
  *this = {};
}

}  // namespace sortie::mapping
