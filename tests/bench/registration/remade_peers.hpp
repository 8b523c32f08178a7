// SPDX-License-Identifier: BSD-3-Clause
// Two of today's lidar odometries, made again from their papers: what they look for and how, not their code.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mapping/registration/level_pose.hpp"

namespace sortie::bench {

using PeerPoints = std::vector<rt::Vector3>;

/// One point, the first, of each voxel.
PeerPoints one_a_voxel(std::span<const rt::Vector3> points_m, double edge_m);

/// Distribution to distribution over voxels (Koide et al., Voxelized GICP, ICRA 2021), with small_gicp's
/// settings: covariances of 10 neighbours made flat (1, 1, 0.001), voxels of 1 m, at most 20 steps of
/// Levenberg and Marquardt until 0.001 m and 0.1 degrees. Trees are PCL's: without it nothing is found.
class VoxelGicp {
 public:
  VoxelGicp();
  ~VoxelGicp();
  VoxelGicp(const VoxelGicp&) = delete;
  VoxelGicp& operator=(const VoxelGicp&) = delete;

  /// Points of the map, in its frame; more may come later. Makes a covariance of each.
  void add(std::span<const rt::Vector3> points_m);
  /// Where a scan was taken, from a start on.
  mapping::RigidPose align(std::span<const rt::Vector3> scan_m, const mapping::RigidPose& start) const;
  bool empty() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

/// Point to point with a threshold that adapts (Vizzo et al., KISS-ICP, RA-L 2023): voxels of `voxel_m`, 20
/// points each, a scan thinned to half of it for the map and to one and a half for the match, at most 500
/// steps until 0.0001, Geman and McClure's kernel.
class KissIcp {
 public:
  KissIcp(double voxel_m, double range_m);
  ~KissIcp();
  KissIcp(const KissIcp&) = delete;
  KissIcp& operator=(const KissIcp&) = delete;

  /// Points of the map, in its frame.
  void add(std::span<const rt::Vector3> points_m);
  /// Where a scan was taken, from a start on; points farther than three times `sigma_m` off are no partners.
  mapping::RigidPose align(std::span<const rt::Vector3> scan_m, const mapping::RigidPose& start,
                           double sigma_m) const;
  /// A scan after the other: constant motion, threshold, match, map. Returns its pose.
  mapping::RigidPose follow(std::span<const rt::Vector3> scan_m);
  static constexpr double kFirstSigma_m = 2.0;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace sortie::bench
