// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/batch.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace sortie::bench {
namespace {

std::uint64_t cell_of(const rt::Vector3& p, double edge_m, int dx = 0, int dy = 0, int dz = 0) {
  const auto part = [edge_m](double v, int d) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / edge_m)) + d + (1 << 20)) &
           0x1fffffu;
  };
  return part(p.x, dx) << 42 | part(p.y, dy) << 21 | part(p.z, dz);
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

template <class Joined>
std::vector<std::uint32_t> components(const std::vector<BatchVoxel>& voxels, double radius_m, Joined joined) {
  std::vector<std::uint32_t> parent(voxels.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const Neighbours neighbours(voxels, radius_m);
  for (std::uint32_t i = 0; i < voxels.size(); ++i) {
    neighbours.around(i, [&](std::size_t j) {
      if (j >= i || !joined(i, j)) return;
      const std::uint32_t a = root_of(parent, i);
      const std::uint32_t b = root_of(parent, static_cast<std::uint32_t>(j));
      parent[std::max(a, b)] = std::min(a, b);
    });
  }
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = root_of(parent, i);
  return parent;
}

}  // namespace

std::vector<BatchVoxel> active_voxels(const mapping::RollingGrid& grid) {
  std::vector<BatchVoxel> all;
  for (std::uint32_t i = 0; i < grid.block_numbers(); ++i) {
    const auto index = static_cast<mapping::BlockIndex>(i);
    const mapping::Block& block = grid.block(index);
    if (!block.in_use()) continue;
    for (unsigned cell = 0; cell < 64; ++cell) {
      if ((block.active >> cell & 1) == 0) continue;
      BatchVoxel voxel{index, cell, grid.centroid_m(block, cell), {}};
      if (grid.holds_normals()) {
        const auto& n = grid.normal(block, cell).normal;
        voxel.normal = {n[0] / 32767.0, n[1] / 32767.0, n[2] / 32767.0};
      }
      all.push_back(voxel);
    }
  }
  return all;
}

Neighbours::Neighbours(const std::vector<BatchVoxel>& voxels, double radius_m)
    : voxels_(&voxels), radius_m_(radius_m) {
  sorted_.reserve(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i)
    sorted_.emplace_back(cell_of(voxels[i].p_m, radius_m), static_cast<std::uint32_t>(i));
  std::sort(sorted_.begin(), sorted_.end());
}

void Neighbours::around_(std::size_t voxel, Call call, void* self) const {
  const rt::Vector3& p = (*voxels_)[voxel].p_m;
  const double most = radius_m_ * radius_m_;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      // Cells along z are neighbours in the list.
      const std::uint64_t first = cell_of(p, radius_m_, dx, dy, -1);
      const std::uint64_t last = cell_of(p, radius_m_, dx, dy, 1);
      auto it = std::lower_bound(sorted_.begin(), sorted_.end(), std::make_pair(first, 0u));
      for (; it != sorted_.end() && it->first <= last; ++it) {
        const rt::Vector3 d = (*voxels_)[it->second].p_m - p;
        if (d.x * d.x + d.y * d.y + d.z * d.z <= most) call(self, it->second);
      }
    }
  }
}

std::vector<BatchNormal> batch_normals(const std::vector<BatchVoxel>& voxels, double radius_m) {
  std::vector<BatchNormal> normals(voxels.size());
  const Neighbours neighbours(voxels, radius_m);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    int count = 0;
    neighbours.around(i, [&](std::size_t j) {
      const rt::Vector3 d = voxels[j].p_m - voxels[i].p_m;
      const Eigen::Vector3d v(d.x, d.y, d.z);
      sum += v;
      square += v * v.transpose();
      ++count;
    });
    if (count < 3) continue;
    const Eigen::Matrix3d covariance = square / count - sum * sum.transpose() / (double(count) * count);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(covariance);
    const Eigen::Vector3d values = solved.eigenvalues();
    if (!(values[2] > 0)) continue;
    const Eigen::Vector3d n = solved.eigenvectors().col(0);
    normals[i] = {
        {n[0], n[1], n[2]}, std::max(0.0, values[0]) / values.sum(), (values[1] - values[0]) / values[2]};
  }
  return normals;
}

std::vector<std::uint32_t> euclidean_batch(const std::vector<BatchVoxel>& voxels, double radius_m) {
  return components(voxels, radius_m, [](std::size_t, std::size_t) { return true; });
}

std::vector<std::uint32_t> smooth_batch(const std::vector<BatchVoxel>& voxels,
                                        const std::vector<BatchNormal>& normals, double radius_m,
                                        double most_angle_rad, double most_curvature) {
  const double least = std::cos(most_angle_rad);
  const auto flat = [&](std::size_t i) {
    const rt::Vector3& n = normals[i].normal;
    return (n.x != 0 || n.y != 0 || n.z != 0) && normals[i].curvature <= most_curvature;
  };
  return components(voxels, radius_m, [&](std::size_t i, std::size_t j) {
    const rt::Vector3& a = normals[i].normal;
    const rt::Vector3& b = normals[j].normal;
    return flat(i) && flat(j) && std::fabs(a.x * b.x + a.y * b.y + a.z * b.z) >= least;
  });
}

}  // namespace sortie::bench
