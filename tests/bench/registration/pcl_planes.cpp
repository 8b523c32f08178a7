// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/pcl_planes.hpp"

#ifdef SORTIE_PEER_PCL
#include <pcl/common/centroid.h>
#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include "tests/bench/registration/hall_case.hpp"
#endif

namespace sortie::bench {

#ifdef SORTIE_PEER_PCL
std::vector<RegionPlane> pcl_planes(std::span<const rt::Vector3> points_m, double& ms) {
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const rt::Vector3& p : points_m)
    cloud->push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  const double begin = step_cpu_ms();
  const auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  const auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setSearchMethod(tree);
  estimation.setInputCloud(cloud);
  estimation.setKSearch(20);
  estimation.compute(*normals);
  pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
  growing.setMinClusterSize(100);
  growing.setSearchMethod(tree);
  growing.setNumberOfNeighbours(20);
  growing.setInputCloud(cloud);
  growing.setInputNormals(normals);
  growing.setSmoothnessThreshold(5.0f / 180.0f * static_cast<float>(M_PI));
  growing.setCurvatureThreshold(0.05f);
  std::vector<pcl::PointIndices> regions;
  growing.extract(regions);
  std::vector<RegionPlane> planes;
  for (const pcl::PointIndices& region : regions) {
    Eigen::Vector4f plane;
    float curvature = 0;
    Eigen::Vector4f middle;
    pcl::computePointNormal(*cloud, region.indices, plane, curvature);
    pcl::compute3DCentroid(*cloud, region.indices, middle);
    const auto vector = [](const Eigen::Vector4f& v) {
      return rt::Vector3{static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
    };
    planes.push_back({vector(middle), vector(plane)});
  }
  ms = step_cpu_ms() - begin;
  return planes;
}
#else
std::vector<RegionPlane> pcl_planes(std::span<const rt::Vector3>, double& ms) {
  ms = 0;
  return {};
}
#endif

}  // namespace sortie::bench
