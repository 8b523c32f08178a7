// SPDX-License-Identifier: BSD-3-Clause
// PCL's registrations of a scan's returns to a map of points.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/registration/scan_sample.hpp"
#include "rt/rotation.hpp"

namespace sortie::bench {

inline constexpr int kScanPeers = 5;
inline constexpr int kGicp = 0;  ///< of these
inline constexpr int kIcp = 2;
inline constexpr int kVoxelGicp = 3;
inline constexpr int kKissIcp = 4;
inline constexpr const char* kScanPeerNames[kScanPeers] = {"PCL GICP", "PCL NDT", "PCL ICP, point to plane",
                                                           "VGICP, made again", "KISS-ICP, made again"};

/// What one made of a scan.
struct PeerResult {
  mapping::RigidPose pose;
  double ms{};  ///< of the thread: source side (trees, covariances) and alignment
};

bool has_pcl();

/// All of them, with what they know of the map made before the clock starts. Points are thinned to one a
/// 0.1-m cube (VoxelGrid). GICP: correspondences to 1 m, 50 iterations; NDT: cells of 1 m, step 0.1, 35
/// iterations; ICP: normals of 20 neighbours, correspondences to 1 m, 50 iterations. The rest is PCL's
/// default. The last two: remade_peers.hpp, KISS-ICP with voxels of 0.5 m and its first threshold.
class ScanPeers {
 public:
  explicit ScanPeers(std::span<const rt::Vector3> map_m);
  ~ScanPeers();
  ScanPeers(const ScanPeers&) = delete;
  ScanPeers& operator=(const ScanPeers&) = delete;

  PeerResult align(int peer, std::span<const mapping::SamplePoint> sample, const mapping::RigidPose& start);
  /// Thread CPU time of making what each knows of the map, thinning included, ms.
  const std::array<double, kScanPeers>& prepared_ms() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace sortie::bench
