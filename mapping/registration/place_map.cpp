// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_map.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
using Word = std::uint64_t;

constexpr std::int32_t kVoxels = 2;  ///< of a cell along an axis
constexpr int kNear = 0;             ///< kinds of bits
constexpr int kOn = 1;
constexpr double kWide = 2.0;  ///< standard deviations that a surface reaches
constexpr std::int32_t kTopVoxels = PlaceMap::kStep * PlaceMap::kNode * PlaceMap::kTop;

struct Size {
  std::int32_t at[3];
};

/// Voxels of a map of cells, with margins.
Size with_margins(std::int32_t x, std::int32_t y, std::int32_t z) {
  constexpr std::int32_t kBoth = 2 * PlaceTiles::kMargin;
  return {{kVoxels * x + kBoth, kVoxels * y + kBoth, kVoxels * z + kBoth}};
}

Size largest(const RegistrationMemory& memory) {
  const auto wide = static_cast<std::int32_t>(memory.window_cells / 2);
  return with_margins(wide, wide, static_cast<std::int32_t>(memory.window_cells_up / 2));
}

std::int32_t words_of_row(std::int32_t voxels) { return (voxels + 63) / 64; }

std::int32_t tops_of(std::int32_t voxels_with_margins) {
  return (voxels_with_margins - 2 * PlaceTiles::kMargin + kTopVoxels - 1) / kTopVoxels;
}
}  // namespace

PlaceMap::PlaceMap(const RegistrationMemory& memory, std::uint32_t most_tops, rt::Arena& arena)
    : most_tops_(most_tops),
      bits_(
          arena.make_array<Word>("place_bits", static_cast<std::size_t>(words_of_row(largest(memory).at[0])) *
                                                   static_cast<std::size_t>(largest(memory).at[1]) *
                                                   static_cast<std::size_t>(largest(memory).at[2]))),
      poses_(arena.make_array<Word>("place_poses", PlaceTiles::words(largest(memory).at, kStep)), kStep),
      parts_(arena.make_array<Word>("place_parts", PlaceTiles::words(largest(memory).at, kStep * kPart)),
             kStep * kPart),
      nodes_(arena.make_array<Word>("place_nodes", PlaceTiles::words(largest(memory).at, kStep * kNode)),
             kStep * kNode) {}

rt::Vector3 PlaceMap::position_m(const PlaceCell& cell) const {
  const auto along = [&](int i) { return (kStep * cell.at[i] + 0.5) * voxel_m_; };
  return origin_m_ + rt::Vector3{along(0), along(1), along(2)};
}

bool PlaceMap::build(const SurfelLayer& layer) {
  for (std::int32_t& tops : tops_) tops = 0;
  wanted_tops_ = 0;
  SurfelBox box;
  for (const std::uint64_t key : layer.keys()) {
    if (key != SurfelLayer::kUnused) box.take(SurfelCell::from_key(key));
  }
  if (box.cells(0) == 0) return false;
  first_ = box.low;
  const auto cells = [&](int i) { return static_cast<std::int32_t>(box.cells(i)); };
  const Size size = with_margins(cells(0), cells(1), cells(2));
  std::copy_n(size.at, 3, size_);
  row_words_ = words_of_row(size_[0]);
  // With 64 bits wherever it runs: surfaces of a keyframe may lie anywhere.
  const auto all = static_cast<std::uint64_t>(size_[2]) * static_cast<std::uint64_t>(size_[1]) *
                   static_cast<std::uint64_t>(row_words_);
  if (all > bits_.size() || !poses_.begin(size_) || !parts_.begin(size_) || !nodes_.begin(size_))
    return false;
  voxel_m_ = layer.cell_m() / kVoxels;
  origin_m_ =
      layer.cell_m() * rt::Vector3{static_cast<double>(first_.at[0]), static_cast<double>(first_.at[1]),
                                   static_cast<double>(first_.at[2])};
  draw(layer, kStep);
  copy_all(kNear);
  draw(layer, 0);
  copy_all(kOn);
  wanted_tops_ = 1;
  for (const std::int32_t voxels : size_) wanted_tops_ *= static_cast<std::uint64_t>(tops_of(voxels));
  if (wanted_tops_ > most_tops_) return false;
  for (int i = 0; i < 3; ++i) tops_[i] = tops_of(size_[i]);
  return true;
}

void PlaceMap::draw(const SurfelLayer& layer, std::int32_t steps) {
  std::fill(bits_.begin(), bits_.end(), Word{0});
  for (std::size_t i = 0; i < layer.keys().size(); ++i) {
    if (layer.keys()[i] == SurfelLayer::kUnused) continue;
    const Surfel& surfel = layer.surfel(static_cast<SurfelIndex>(i));
    if (surfel.count > 0) draw(surfel, SurfelCell::from_key(layer.keys()[i]), steps);
  }
}

/// Poses of a part stand 0 and 1 step from its first, those of a node 0 to 3.
void PlaceMap::copy_all(int kind) {
  copy(kind, poses_);
  for (int axis = 0; axis < 3; ++axis) spread(axis, kStep);
  copy(kind, parts_);
  for (int axis = 0; axis < 3; ++axis) spread(axis, 2 * kStep);
  copy(kind, nodes_);
}

/// Voxels that come within half of some steps of the box of the surface, two standard deviations wide.
void PlaceMap::draw(const Surfel& surfel, const SurfelCell& cell, std::int32_t steps) {
  double reach[3];
  rt::Vector3 along[3];
  for (int i = 0; i < 3; ++i) {
    along[i] = surfel.along(i);
    // Half a voxel for the voxel, and half the steps along each axis for the pose.
    const double grown = 0.5 * (1 + steps) * voxel_m_ *
                         (std::fabs(along[i].x) + std::fabs(along[i].y) + std::fabs(along[i].z));
    reach[i] = kWide * std::sqrt(surfel.variance(i)) + grown;
  }
  constexpr std::int32_t kSide = kVoxels + 2;  // and a voxel on either side
  for (std::int32_t k = 0; k < kSide * kSide * kSide; ++k) {
    const std::int32_t at[3] = {k % kSide - 1, k / kSide % kSide - 1, k / (kSide * kSide) - 1};
    const auto middle = [&](int i) { return (at[i] - 0.5) * voxel_m_; };
    const rt::Vector3 off = rt::Vector3{middle(0), middle(1), middle(2)} - surfel.mean();
    bool inside = true;
    for (int i = 0; i < 3; ++i) inside = inside && std::fabs(rt::dot(off, along[i])) <= reach[i];
    if (!inside) continue;
    std::int32_t voxel[3];
    for (int i = 0; i < 3; ++i)
      voxel[i] = kVoxels * (cell.at[i] - first_.at[i]) + at[i] + PlaceTiles::kMargin;
    bits_[row(voxel[1], voxel[2]) + static_cast<std::size_t>(voxel[0] / 64)] |= Word{1} << (voxel[0] % 64);
  }
}

/// Each voxel takes what stands `by` after it along an axis.
void PlaceMap::spread(int axis, std::int32_t by) {
  const auto words = static_cast<std::size_t>(row_words_);
  const std::size_t all = row(0, size_[2]);
  if (axis == 0) {
    for (std::size_t i = 0; i < all; ++i) {
      const Word next = (i + 1) % words != 0 ? bits_[i + 1] : 0;
      bits_[i] |= bits_[i] >> by | next << (64 - by);
    }
    return;
  }
  for (std::int32_t z = 0; z + (axis == 2 ? by : 0) < size_[2]; ++z) {
    for (std::int32_t y = 0; y + (axis == 1 ? by : 0) < size_[1]; ++y) {
      const std::size_t from = axis == 1 ? row(y + by, z) : row(y, z + by);
      for (std::size_t w = 0; w < words; ++w) bits_[row(y, z) + w] |= bits_[from + w];
    }
  }
}

void PlaceMap::copy(int kind, PlaceTiles& tiles) const {
  for (std::int32_t z = 0; z < size_[2]; ++z) {
    for (std::int32_t y = 0; y < size_[1]; ++y) {
      for (std::int32_t x = 0; x < size_[0]; ++x) {
        if ((bits_[row(y, z) + static_cast<std::size_t>(x / 64)] >> (x % 64) & 1) != 0)
          tiles.set(kind, x, y, z);
      }
    }
  }
}

}  // namespace sortie::mapping
