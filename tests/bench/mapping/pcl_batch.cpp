// SPDX-License-Identifier: BSD-3-Clause
// PCL's libraries were built with Eigen's vectors: whoever shares clouds with them must use the same
// alignment.
#undef EIGEN_DONT_VECTORIZE
#include "tests/bench/mapping/pcl_batch.hpp"

#ifdef SORTIE_PEER_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/region_growing.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace sortie::bench {
namespace {
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

double pcl_cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

std::uint64_t differing(const std::vector<pcl::PointIndices>& clusters,
                        const std::vector<std::uint32_t>& segments) {
  std::uint64_t wrong = 0;
  std::set<std::uint32_t> taken;
  for (const pcl::PointIndices& cluster : clusters) {
    std::map<std::uint32_t, std::uint64_t> parts;
    for (const int i : cluster.indices) ++parts[segments[static_cast<std::size_t>(i)]];
    std::uint64_t most = 0;
    for (const auto& [segment, count] : parts) {
      if (!taken.insert(segment).second) wrong += count;
      most = std::max(most, count);
    }
    wrong += cluster.indices.size() - most;
  }
  return wrong;
}
}  // namespace

bool has_pcl() { return true; }

std::uint64_t run_pcl(const PclInput& input, bool smooth, PclTimes& times) {
  const auto cloud = std::make_shared<Cloud>();
  for (const auto& p : input.voxels) cloud->push_back({p[0], p[1], p[2]});
  const auto all = std::make_shared<Cloud>(*cloud);
  for (const auto& p : input.scan) all->push_back({p[0], p[1], p[2]});
  const double t0 = pcl_cpu_ms();
  pcl::VoxelGrid<pcl::PointXYZ> filter;
  filter.setInputCloud(all);
  filter.setLeafSize(0.1f, 0.1f, 0.1f);
  Cloud filtered;
  filter.filter(filtered);
  const double t1 = pcl_cpu_ms();
  const auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  tree->setInputCloud(cloud);
  const double t2 = pcl_cpu_ms();
  double t3 = t2;
  std::vector<pcl::PointIndices> clusters;
  if (smooth) {
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setInputCloud(cloud);
    estimation.setSearchMethod(tree);
    estimation.setRadiusSearch(0.3);
    const auto normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
    estimation.compute(*normals);
    t3 = pcl_cpu_ms();
    pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
    growing.setMinClusterSize(1);
    growing.setMaxClusterSize(1 << 30);
    growing.setSearchMethod(tree);
    growing.setNumberOfNeighbours(30);
    growing.setInputCloud(cloud);
    growing.setInputNormals(normals);
    growing.setSmoothnessThreshold(0.07f);
    growing.setCurvatureThreshold(0.05f);
    growing.extract(clusters);
    times.normals_ms.add(t3 - t2);
    for (std::size_t i = 0; i < input.normals.size(); ++i) {
      const auto& ours = input.normals[i];
      const pcl::Normal& theirs = normals->points[i];
      const double dot = std::fabs(static_cast<double>(ours[0]) * static_cast<double>(theirs.normal_x) +
                                   static_cast<double>(ours[1]) * static_cast<double>(theirs.normal_y) +
                                   static_cast<double>(ours[2]) * static_cast<double>(theirs.normal_z));
      if (dot > 0 && theirs.curvature < 0.05f)
        times.angles_deg.push_back(57.29577951308232 * std::acos(std::min(1.0, dot)));
    }
  } else {
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setClusterTolerance(0.2);
    extraction.setMinClusterSize(1);
    extraction.setMaxClusterSize(1 << 30);
    extraction.setSearchMethod(tree);
    extraction.setInputCloud(cloud);
    extraction.extract(clusters);
  }
  const double t4 = pcl_cpu_ms();
  times.filter_ms.add(t1 - t0);
  times.tree_ms.add(t2 - t1);
  times.segments_ms.add(t4 - t3);
  times.whole_ms.add(t4 - t0);
  return smooth ? 0 : differing(clusters, input.segments);
}

}  // namespace sortie::bench
#else
namespace sortie::bench {
bool has_pcl() { return false; }
std::uint64_t run_pcl(const PclInput&, bool, PclTimes&) { return 0; }
}  // namespace sortie::bench
#endif
