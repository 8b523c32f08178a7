// SPDX-License-Identifier: BSD-3-Clause
// PCL's libraries were built with Eigen's vectors: whoever shares clouds with them must use the same
// alignment.
#undef EIGEN_DONT_VECTORIZE
#include "tests/bench/registration/scan_peers.hpp"

#include "tests/bench/registration/remade_peers.hpp"

#ifdef SORTIE_PEER_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <time.h>

namespace sortie::bench {
namespace {
using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using NormalCloud = pcl::PointCloud<pcl::PointNormal>;

constexpr double kReach = 1.0;
constexpr int kNeighbours = 20;
constexpr double kKissVoxel_m = 0.5;

double pcl_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

rt::Vector3 vector_of(const Point& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Eigen::Matrix4f matrix_of(const mapping::RigidPose& pose) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  const double p[3] = {pose.p.x, pose.p.y, pose.p.z};
  Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) m(i, k) = static_cast<float>(r.m[3 * i + k]);
    m(i, 3) = static_cast<float>(p[i]);
  }
  return m;
}

mapping::RigidPose pose_of(const Eigen::Matrix4f& m) {
  const Eigen::Quaterniond q(m.block<3, 3>(0, 0).cast<double>());
  return {{static_cast<double>(m(0, 3)), static_cast<double>(m(1, 3)), static_cast<double>(m(2, 3))},
          rt::normalised(rt::Quaternion{q.w(), q.x(), q.y(), q.z()})};
}

/// Makes the map's tree ahead of the first scan.
template <class Registration>
class Prepared : public Registration {
 public:
  template <class MapPtr>
  void prepare(const MapPtr& map) {
    this->setInputTarget(map);
    this->tree_->setInputCloud(map);
    this->target_cloud_updated_ = false;
  }
};

/// Its covariances as well.
class Gicp : public Prepared<pcl::GeneralizedIterativeClosestPoint<Point, Point>> {
 public:
  void prepare_all(const Cloud::Ptr& map) {
    prepare(map);
    const auto covariances = std::make_shared<MatricesVector>();
    computeCovariances<Point>(map, tree_, *covariances);
    setTargetCovariances(covariances);
  }
};

NormalCloud::Ptr with_normals(const Cloud::Ptr& cloud) {
  pcl::NormalEstimation<Point, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setKSearch(kNeighbours);
  const auto normals = std::make_shared<NormalCloud>();
  estimation.compute(*normals);
  for (std::size_t i = 0; i < cloud->size(); ++i)
    (*normals)[i].getVector3fMap() = (*cloud)[i].getVector3fMap();
  NormalCloud kept;
  for (const pcl::PointNormal& p : *normals) {
    if (std::isfinite(p.normal_x)) kept.push_back(p);
  }
  return std::make_shared<NormalCloud>(kept);
}
}  // namespace

struct ScanPeers::Inside {
  Gicp gicp;
  Prepared<pcl::NormalDistributionsTransform<Point, Point>> ndt;
  Prepared<pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal>> icp;
  VoxelGicp voxel_gicp;
  KissIcp kiss{kKissVoxel_m, 50.0};
  std::array<double, kScanPeers> prepared_ms{};
};

bool has_pcl() { return true; }

ScanPeers::ScanPeers(std::span<const rt::Vector3> map_m) : inside_(std::make_unique<Inside>()) {
  const auto all = std::make_shared<Cloud>();
  for (const rt::Vector3& p : map_m)
    all->push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  const double t0 = pcl_ms();
  pcl::VoxelGrid<Point> filter;
  filter.setInputCloud(all);
  filter.setLeafSize(0.1f, 0.1f, 0.1f);
  const auto map = std::make_shared<Cloud>();
  filter.filter(*map);
  const double t1 = pcl_ms();
  inside_->gicp.prepare_all(map);
  inside_->gicp.setMaxCorrespondenceDistance(kReach);
  inside_->gicp.setMaximumIterations(50);
  const double t2 = pcl_ms();
  inside_->ndt.setResolution(1.0f);
  inside_->ndt.prepare(map);
  inside_->ndt.setMaximumIterations(35);
  inside_->ndt.setTransformationEpsilon(0.0001);
  const double t3 = pcl_ms();
  inside_->icp.prepare(with_normals(map));
  inside_->icp.setMaxCorrespondenceDistance(kReach);
  inside_->icp.setMaximumIterations(50);
  inside_->icp.setTransformationEpsilon(1e-8);
  const double t4 = pcl_ms();
  PeerPoints points;
  for (const Point& p : *map) points.push_back(vector_of(p));
  inside_->voxel_gicp.add(points);
  const double t5 = pcl_ms();
  inside_->kiss.add(points);
  const double t6 = pcl_ms();
  inside_->prepared_ms = {t2 - t0, t3 - t2 + t1 - t0, t4 - t3 + t1 - t0, t5 - t4 + t1 - t0,
                          t6 - t5 + t1 - t0};
}

ScanPeers::~ScanPeers() = default;

const std::array<double, kScanPeers>& ScanPeers::prepared_ms() const { return inside_->prepared_ms; }

PeerResult ScanPeers::align(int peer, std::span<const mapping::SamplePoint> sample,
                            const mapping::RigidPose& start) {
  const auto source = std::make_shared<Cloud>();
  const auto normals = std::make_shared<NormalCloud>();
  for (const mapping::SamplePoint& p : sample) {
    source->push_back({p.x_m, p.y_m, p.z_m});
    pcl::PointNormal q;
    q.x = p.x_m;
    q.y = p.y_m;
    q.z = p.z_m;
    normals->push_back(q);  // only the map's normals are used
  }
  PeerPoints points;
  for (const Point& p : *source) points.push_back(vector_of(p));
  const Eigen::Matrix4f guess = matrix_of(start);
  const double begin = pcl_ms();
  PeerResult result;
  const auto run = [&](auto& registration, const auto& cloud, auto aligned) {
    registration.setInputSource(cloud);
    registration.align(aligned, guess);
    result.pose = pose_of(registration.getFinalTransformation());
  };
  if (peer == kGicp) run(inside_->gicp, source, Cloud{});
  if (peer == 1) run(inside_->ndt, source, Cloud{});
  if (peer == kIcp) run(inside_->icp, normals, NormalCloud{});
  if (peer == kVoxelGicp) result.pose = inside_->voxel_gicp.align(points, start);
  if (peer == kKissIcp) {
    const PeerPoints few = one_a_voxel(points, 1.5 * kKissVoxel_m);
    result.pose = inside_->kiss.align(few, start, KissIcp::kFirstSigma_m);
  }
  result.ms = pcl_ms() - begin;
  return result;
}

}  // namespace sortie::bench
#else
namespace sortie::bench {
struct ScanPeers::Inside {
  std::array<double, kScanPeers> prepared_ms{};
};
bool has_pcl() { return false; }
ScanPeers::ScanPeers(std::span<const rt::Vector3>) : inside_(std::make_unique<Inside>()) {}
ScanPeers::~ScanPeers() = default;
const std::array<double, kScanPeers>& ScanPeers::prepared_ms() const { return inside_->prepared_ms; }
PeerResult ScanPeers::align(int, std::span<const mapping::SamplePoint>, const mapping::RigidPose&) {
  return {};
}
}  // namespace sortie::bench
#endif
