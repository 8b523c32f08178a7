// SPDX-License-Identifier: BSD-3-Clause
#include "hil/voxel_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sortie::hil {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Along one axis, in cells: where the ray is and when it crosses the next face.
struct Walk {
  std::int32_t cell{};
  std::int32_t step{};
  double next{kNever};   // way to the next face, cells
  double every{kNever};  // way from face to face
};

Walk start(double at, double direction, double begin, std::int32_t size) {
  Walk axis;
  const double entry = at + begin * direction;
  axis.cell = std::clamp(static_cast<std::int32_t>(std::floor(entry)), 0, size - 1);
  if (direction > 0) {
    axis.step = 1;
    axis.every = 1.0 / direction;
    axis.next = (axis.cell + 1 - at) / direction;
  } else if (direction < 0) {
    axis.step = -1;
    axis.every = -1.0 / direction;
    axis.next = (axis.cell - at) / direction;
  }
  return axis;
}

}  // namespace

std::uint64_t VoxelWorld::words(const std::int32_t (&size)[3]) {
  std::uint64_t cells = 1;
  for (const std::int32_t n : size) cells *= n > 0 ? static_cast<std::uint64_t>(n) : 0;
  return (cells + 31) / 32;
}

VoxelWorld::VoxelWorld(double voxel_m, const Vec3& low_m, const std::int32_t (&size)[3],
                       std::span<std::uint32_t> bits)
    : voxel_m_(voxel_m), low_m_(low_m) {
  bool good = voxel_m >= 1e-3 && voxel_m <= 100.0 && std::isfinite(low_m.x + low_m.y + low_m.z);
  for (int a = 0; a < 3; ++a) {
    good = good && size[a] >= 1 && size[a] <= 4096;
    size_[a] = size[a];
  }
  if (!good || bits.size() < words(size)) return;
  bits_ = bits.first(static_cast<std::size_t>(words(size)));
  std::fill(bits_.begin(), bits_.end(), 0u);
  usable_ = true;
}

std::uint64_t VoxelWorld::bit_of(std::int32_t x, std::int32_t y, std::int32_t z) const {
  return (static_cast<std::uint64_t>(z) * static_cast<std::uint64_t>(size_[1]) +
          static_cast<std::uint64_t>(y)) *
             static_cast<std::uint64_t>(size_[0]) +
         static_cast<std::uint64_t>(x);
}

bool VoxelWorld::solid(std::int32_t x, std::int32_t y, std::int32_t z) const {
  if (!usable_ || x < 0 || y < 0 || z < 0 || x >= size_[0] || y >= size_[1] || z >= size_[2]) return false;
  const std::uint64_t index = bit_of(x, y, z);
  return (bits_[static_cast<std::size_t>(index / 32)] >> (index % 32) & 1u) != 0;
}

Status VoxelWorld::add(const Vec3& point_m) {
  const Vec3 u = (1.0 / voxel_m_) * (point_m - low_m_);
  const bool inside = usable_ && u.x >= 0 && u.x < size_[0] && u.y >= 0 && u.y < size_[1] && u.z >= 0 &&
                      u.z < size_[2];  // false for what is no number
  if (!inside) return Status::out_of_range;
  const auto x = static_cast<std::int32_t>(u.x);
  const auto y = static_cast<std::int32_t>(u.y);
  const auto z = static_cast<std::int32_t>(u.z);
  if (solid(x, y, z)) return Status::ok;
  const std::uint64_t index = bit_of(x, y, z);
  bits_[static_cast<std::size_t>(index / 32)] |= 1u << (index % 32);
  ++solids_;
  return Status::ok;
}

Hit VoxelWorld::cast(const Vec3& origin_m, const Vec3& direction, double max_range_m) const {
  Hit hit;
  hit.range_m = max_range_m;
  const Vec3 u = (1.0 / voxel_m_) * (origin_m - low_m_);
  if (!usable_ || !std::isfinite(u.x + u.y + u.z)) return hit;
  const double at[3] = {u.x, u.y, u.z};
  const double way[3] = {direction.x, direction.y, direction.z};
  const double most = max_range_m / voxel_m_;
  double begin = 0.0;  // where the ray is in the box, in cells
  double end = most;
  int through = -1;  // axis of the face that it came in by
  for (int a = 0; a < 3; ++a) {
    if (way[a] == 0.0) {
      if (!(at[a] >= 0 && at[a] < size_[a])) return hit;
      continue;
    }
    const double first = (way[a] > 0 ? 0.0 - at[a] : size_[a] - at[a]) / way[a];
    const double last = (way[a] > 0 ? size_[a] - at[a] : 0.0 - at[a]) / way[a];
    if (first > begin) {
      begin = first;
      through = a;
    }
    end = std::min(end, last);
  }
  if (!(begin < end)) return hit;
  Walk axes[3];
  for (int a = 0; a < 3; ++a) axes[a] = start(at[a], way[a], begin, size_[a]);
  // Bounded by the box: each turn moves one cell on along one axis.
  for (double here = begin; here < most;) {
    const int next = axes[0].next <= axes[1].next ? (axes[0].next <= axes[2].next ? 0 : 2)
                                                  : (axes[1].next <= axes[2].next ? 1 : 2);
    if (solid(axes[0].cell, axes[1].cell, axes[2].cell)) {
      const bool within = through < 0;
      const double range_m = within ? 0.0 : voxel_m_ * 0.5 * (here + axes[next].next);
      if (range_m > max_range_m) return hit;
      hit.range_m = range_m;
      hit.solid = 0;
      hit.reflectivity = kReflectivity;
      if (within) return hit;
      const double sign = way[through] > 0 ? -1.0 : 1.0;
      hit.normal = {through == 0 ? sign : 0.0, through == 1 ? sign : 0.0, through == 2 ? sign : 0.0};
      return hit;
    }
    here = axes[next].next;
    axes[next].cell += axes[next].step;
    axes[next].next += axes[next].every;
    if (axes[next].cell < 0 || axes[next].cell >= size_[next]) return hit;
    through = next;
  }
  return hit;
}

}  // namespace sortie::hil
