// SPDX-License-Identifier: BSD-3-Clause
// A grid of surfels in fixed memory, in a window that wraps around.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "mapping/registration/surfel.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

using SurfelIndex = std::uint32_t;
inline constexpr SurfelIndex kNoSurfel = 0xffffffff;

/// A cell by its whole coordinates, each in [-2^20, 2^20), and as a 63-bit key.
struct SurfelCell {
  static constexpr std::int32_t kLimit = 1 << 20;
  std::int32_t at[3]{};
  SORTIE_FIELDS(at)

  constexpr std::uint64_t key() const {
    const auto part = [](std::int32_t i) { return static_cast<std::uint64_t>(std::int64_t{i} + kLimit); };
    return part(at[0]) | part(at[1]) << 21 | part(at[2]) << 42;
  }
  static constexpr SurfelCell from_key(std::uint64_t key) {
    const auto part = [key](int shift) {
      return static_cast<std::int32_t>((key >> shift) & 0x1fffffu) - kLimit;
    };
    return {{part(0), part(21), part(42)}};
  }
};

/// The box about some cells: from the first to the last along each axis.
struct SurfelBox {
  SurfelCell low{{SurfelCell::kLimit, SurfelCell::kLimit, SurfelCell::kLimit}};
  SurfelCell high{{-SurfelCell::kLimit, -SurfelCell::kLimit, -SurfelCell::kLimit}};

  void take(const SurfelCell& cell) {
    for (int i = 0; i < 3; ++i) {
      low.at[i] = std::min(low.at[i], cell.at[i]);
      high.at[i] = std::max(high.at[i], cell.at[i]);
    }
  }
  /// Along an axis; 0: there are none.
  std::uint32_t cells(int axis) const {
    return low.at[axis] > high.at[axis] ? 0 : static_cast<std::uint32_t>(high.at[axis] - low.at[axis] + 1);
  }
};

/// A point's cell and its place in it, whole kSurfelSteps from the centre.
struct SurfelPlace {
  SurfelCell cell;
  std::int32_t at[3]{};
};

/// Memory of a layer, which outlives it: value-initialised arrays of one length, but for the window. A layer
/// without `surfels` keeps sums alone.
struct SurfelLayerMemory {
  std::span<SurfelIndex> window;  ///< 2^(2 bits_xy + bits_z)
  std::span<std::uint64_t> keys;
  std::span<SurfelSums> sums;
  std::span<Surfel> surfels;
  std::span<SurfelIndex> free;
  std::span<std::uint32_t> newest;  ///< number of the scan that touched it last
  std::span<SurfelIndex> others;    ///< of each, the surfel of its other side; none without Gaussians
};
/// Bits of a window of so many cells along an axis, or of the next power of two.
constexpr unsigned window_bits(std::uint32_t cells) {
  return static_cast<unsigned>(std::countr_zero(std::bit_ceil(cells)));
}
/// Arrays of an arena for `surfels` of them, reported under these names; with Gaussians, or sums alone.
SurfelLayerMemory surfel_memory(rt::Arena& arena, const char* window, const char* name, unsigned bits_xy,
                                unsigned bits_z, std::size_t surfels, bool gaussians = true);

/// What became of the points. in = used + all others; the last two count surfels.
struct SurfelLayerCounts {
  std::uint64_t in{};
  std::uint64_t used{};
  std::uint64_t outside{};    ///< beyond the reach of whole coordinates
  std::uint64_t pool_full{};  ///< points of cells that found no room
  std::uint64_t created{};
  std::uint64_t evicted{};  ///< a whole window away from a newer one, or beyond the window about the sensor
  SORTIE_FIELDS(in, used, outside, pool_full, created, evicted)
};

/// Surfels by their cells. One look-up a cell, no probing, no heap. What a scan does to it does not depend on
/// the order of its points: new cells get their room in the order of their keys.
///
/// A wall or a floor that is seen from both sides has two surfaces, and its thickness apart they would make
/// one that is neither, or draw what was seen of one to the other. So a layer with Gaussians keeps two
/// surfels of such a cell: what a ray finds that comes from behind a thin surface is of its other side.
class SurfelLayer {
 public:
  /// 148 bytes a surfel, 68 of them for its Gaussian, and 4 an entry of the window. `cell_m`: edge, [0.01,
  /// 100]. A cell has a Gaussian from `min_points` on, and fades from `memory_points` on (at most 32,768).
  /// `planar`: see surfel_of().
  SurfelLayer(double cell_m, unsigned bits_xy, unsigned bits_z, std::uint32_t min_points,
              std::uint32_t memory_points, const SurfelLayerMemory& memory, bool planar = false);

  double cell_m() const { return cell_m_; }
  /// Cells of the window along x and y, and along z.
  std::uint32_t window_xy() const { return 1u << bits_xy_; }
  std::uint32_t window_z() const { return 1u << bits_z_; }
  std::size_t size() const { return memory_.keys.size() - free_; }
  const SurfelLayerCounts& counts() const { return counts_; }

  /// False: beyond the reach of whole coordinates, or not finite.
  bool place(double x_m, double y_m, double z_m, SurfelPlace& out) const {
    const double u[3] = {x_m * per_cell_, y_m * per_cell_, z_m * per_cell_};
    constexpr double kFar = SurfelCell::kLimit - 2;
    for (int i = 0; i < 3; ++i) {
      if (!(u[i] > -kFar && u[i] < kFar)) return false;
      // Shifted to be positive: a cast then rounds down.
      const auto cell = static_cast<std::int32_t>(u[i] + SurfelCell::kLimit) - SurfelCell::kLimit;
      out.cell.at[i] = cell;
      out.at[i] = static_cast<std::int32_t>((u[i] - cell) * kSurfelSteps) - kSurfelSteps / 2;
    }
    return true;
  }
  /// Surfel of a cell, of the side that was seen first, or kNoSurfel.
  SurfelIndex find(const SurfelCell& cell) const {
    const SurfelIndex index = memory_.window[entry(cell)];
    return index != kNoSurfel && memory_.keys[index] == cell.key() ? index : kNoSurfel;
  }
  /// The Gaussian of one, in a layer that keeps them; its count is 0 where it has too few points yet.
  const Surfel& surfel(SurfelIndex index) const { return memory_.surfels[index]; }
  /// The same, or null where there is no Gaussian.
  const Surfel* surfel_at(const SurfelCell& cell) const {
    const SurfelIndex index = find(cell);
    return index == kNoSurfel || memory_.surfels[index].count == 0 ? nullptr : &memory_.surfels[index];
  }
  /// Of the side that a ray into the cell can have met, the surfel that has a Gaussian, or kNoSurfel.
  SurfelIndex find_met(const SurfelCell& cell, const rt::Vector3& ray) const {
    SurfelIndex index = find(cell);
    if (index != kNoSurfel && memory_.surfels[index].count > 0) index = met(index, ray);
    return index != kNoSurfel && memory_.surfels[index].count > 0 ? index : kNoSurfel;
  }
  /// The same, or null.
  const Surfel* surfel_met(const SurfelCell& cell, const rt::Vector3& ray) const {
    const SurfelIndex index = find_met(cell, ray);
    return index == kNoSurfel ? nullptr : &memory_.surfels[index];
  }
  /// A place in its cell, from the cell's centre.
  rt::Vector3 from_centre_m(const SurfelPlace& place) const {
    const double step = cell_m_ / kSurfelSteps;
    return {step * place.at[0], step * place.at[1], step * place.at[2]};
  }
  rt::Vector3 centre_m(const SurfelCell& cell) const {
    return {(cell.at[0] + 0.5) * cell_m_, (cell.at[1] + 0.5) * cell_m_, (cell.at[2] + 0.5) * cell_m_};
  }
  /// Of the surfel that find() gives: the one of its surface's other side, or kNoSurfel.
  SurfelIndex other_side(SurfelIndex index) const { return memory_.others[index]; }
  /// Which side of the surface that find() gave a ray into its cell can have met: where it comes from behind
  /// a thin surface, the other one. kNoSurfel: nobody has seen that side. `ray`: of any length.
  SurfelIndex met(SurfelIndex index, const rt::Vector3& ray) const {
    const Surfel& surfel = memory_.surfels[index];
    const double slope = rt::dot(surfel.normal(), ray);
    if (!(slope > 0.0) || slope * slope < kGrazing2 * rt::dot(ray, ray) || !has_sides(surfel)) return index;
    return memory_.others[index];
  }
  std::span<const std::uint64_t> keys() const { return memory_.keys; }
  static constexpr std::uint64_t kUnused = ~std::uint64_t{0};

  /// Adds points of the map's frame that were seen from `from_m`. `cells` is scratch, as long as `points_m`;
  /// `scan` is the scan's number, which rises by one from scan to scan. Returns the surfels that took points,
  /// in scratch.
  std::span<const std::uint64_t> insert(std::span<const rt::Vector3> points_m, const rt::Vector3& from_m,
                                        std::uint32_t scan, std::span<std::uint64_t> cells);
  /// Gives back what lies beyond the window about a place. From then on cells beyond it get only what room
  /// those within it leave. Looks at every surfel.
  void evict_beyond(const rt::Vector3& middle_m);
  void clear();

  /// The surfels that are there, by rising key. A sort; lives until the layer changes.
  std::span<const SurfelIndex> by_key() const;
  SurfelRecord record(SurfelIndex index) const {
    return {memory_.keys[index], memory_.sums[index], has_gaussians() ? memory_.surfels[index] : Surfel{}};
  }
  /// Adds a surfel that was kept; what it was kept in gives them by rising key, after a clear(). malformed:
  /// it cannot be one (fault_of()); full: no room; out_of_range: another one has its place in the window.
  Status put(const SurfelRecord& record);
  /// Adds sums to a cell, which is made where there is none; the cell's Gaussian stays as it is. kNoSurfel:
  /// no room, or another one has its place in the window. The caller sees to it that a cell's points do not
  /// become more than kMostSurfelPoints.
  SurfelIndex add(const SurfelCell& cell, const SurfelSums& sums);
  /// Surfels by rising key, whatever their places in memory were: no answer depends on these.
  void archive(rt::Archive& archive);

 private:
  static constexpr std::uint64_t kOtherSide = SurfelRecord::kOtherSide;
  /// Squared cosine between a ray and a normal: what grazes a surface does not say from which side.
  static constexpr double kGrazing2 = 0.01;
  bool has_sides(const Surfel& surfel) const {
    return surfel.count >= kSureSurface && surfel.variance(0) <= thin_m2_ && is_surface(surfel, cell_m_);
  }
  std::uint32_t entry(const SurfelCell& cell) const {
    const auto part = [](std::int32_t i, std::uint32_t mask) { return static_cast<std::uint32_t>(i) & mask; };
    return (part(cell.at[0], mask_xy_) << bits_xy_ | part(cell.at[1], mask_xy_)) << bits_z_ |
           part(cell.at[2], mask_z_);
  }
  bool has_gaussians() const { return !memory_.surfels.empty(); }
  bool within_window(const SurfelCell& cell) const;
  void make_room(std::span<std::uint64_t> missing, std::uint32_t scan);
  void release(SurfelIndex index);

  double cell_m_;
  double per_cell_;
  double thin_m2_;
  unsigned bits_xy_;
  unsigned bits_z_;
  std::uint32_t mask_xy_;
  std::uint32_t mask_z_;
  std::uint32_t min_points_;
  std::uint32_t memory_points_;
  bool planar_;
  SurfelLayerMemory memory_;
  std::size_t free_{};  ///< entries of memory_.free
  SurfelCell middle_;   ///< of the window
  bool has_middle_{};   ///< false: nothing was evicted about a place yet; any cell is a near one
  SurfelLayerCounts counts_;
};

}  // namespace sortie::mapping
