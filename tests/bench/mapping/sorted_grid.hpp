// SPDX-License-Identifier: BSD-3-Clause
// The peer of insertion: a voxel grid as one sorted vector, the layout of the published incremental system.
// Each scan is sorted by cell and merged with all voxels into new vectors.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rt/samples.hpp"

namespace sortie::bench {

/// Sorted voxels and, apart from them, their points in the same order. Every voxel is active. float32
/// throughout, as the layout it stands for. Cost of an insertion: n log n of the scan and a copy of the whole
/// map.
class SortedGrid {
 public:
  explicit SortedGrid(float voxel_size_m) : to_cells_(1.0f / voxel_size_m) {}

  /// Adds points that are in the world already.
  void insert(const std::vector<rt::ScanPoint>& points) {
    fresh_.clear();
    for (const rt::ScanPoint& p : points) fresh_.push_back({index_of(p), p.x_m, p.y_m, p.z_m});
    std::sort(fresh_.begin(), fresh_.end(), [](const Entry& a, const Entry& b) { return a.index < b.index; });
    std::vector<Voxel> voxels;
    std::vector<Point> cloud;
    voxels.reserve(voxels_.size() + fresh_.size());
    cloud.reserve(voxels_.size() + fresh_.size());
    std::size_t old = 0;
    for (std::size_t i = 0; i < fresh_.size();) {
      const std::uint64_t index = fresh_[i].index;
      for (; old < voxels_.size() && voxels_[old].index < index; ++old) {
        voxels.push_back(voxels_[old]);
        cloud.push_back(cloud_[old]);
      }
      Voxel voxel{index, 0};
      Point point{};
      if (old < voxels_.size() && voxels_[old].index == index) {
        voxel = voxels_[old];
        point = cloud_[old++];
      }
      const auto held = static_cast<float>(voxel.points);
      float sum[3] = {held * point.at[0], held * point.at[1], held * point.at[2]};
      for (; i < fresh_.size() && fresh_[i].index == index; ++i) {
        sum[0] += fresh_[i].x_m;
        sum[1] += fresh_[i].y_m;
        sum[2] += fresh_[i].z_m;
        ++voxel.points;
      }
      for (int axis = 0; axis < 3; ++axis) point.at[axis] = sum[axis] / static_cast<float>(voxel.points);
      voxels.push_back(voxel);
      cloud.push_back(point);
    }
    for (; old < voxels_.size(); ++old) {
      voxels.push_back(voxels_[old]);
      cloud.push_back(cloud_[old]);
    }
    voxels_.swap(voxels);
    cloud_.swap(cloud);
  }

  /// Keeps what lies within a radius of a place, horizontally.
  void keep_within(double x_m, double y_m, double radius_m) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < voxels_.size(); ++i) {
      const double dx = static_cast<double>(cloud_[i].at[0]) - x_m;
      const double dy = static_cast<double>(cloud_[i].at[1]) - y_m;
      if (dx * dx + dy * dy > radius_m * radius_m) continue;
      voxels_[kept] = voxels_[i];
      cloud_[kept++] = cloud_[i];
    }
    voxels_.resize(kept);
    cloud_.resize(kept);
  }
  std::size_t size() const { return voxels_.size(); }

 private:
  struct Entry {
    std::uint64_t index;
    float x_m;
    float y_m;
    float z_m;
  };
  struct Voxel {
    std::uint64_t index;
    std::uint32_t points;
  };
  struct Point {  // 32 bytes, as the layout it stands for
    float at[4];
    std::uint32_t fields[4];
  };
  std::uint64_t index_of(const rt::ScanPoint& p) const {
    const auto part = [this](float v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v * to_cells_)) + (1 << 19));
    };
    return part(p.x_m) | part(p.y_m) << 20 | part(p.z_m) << 40;
  }

  float to_cells_;
  std::vector<Entry> fresh_;
  std::vector<Voxel> voxels_;
  std::vector<Point> cloud_;
};

}  // namespace sortie::bench
