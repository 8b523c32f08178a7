// SPDX-License-Identifier: BSD-3-Clause
// PCL's libraries were built with Eigen's vectors: whoever shares clouds with them must use the same
// alignment.
#undef EIGEN_DONT_VECTORIZE
#include "tests/bench/registration/remade_peers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#ifdef SORTIE_PEER_PCL
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#endif
#include <Eigen/Dense>

namespace sortie::bench {
namespace {

using Vectors = std::vector<Eigen::Vector3d>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kGicpVoxel_m = 1.0;
constexpr double kGicpReach_m = 1.0;
constexpr std::size_t kPointsOfVoxel = 20;

Eigen::Vector3d eigen_of(const rt::Vector3& v) { return {v.x, v.y, v.z}; }

Vectors eigen_of(std::span<const rt::Vector3> points) {
  Vectors out;
  for (const rt::Vector3& p : points) out.push_back(eigen_of(p));
  return out;
}

Eigen::Isometry3d eigen_of(const mapping::RigidPose& pose) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(pose.q.w, pose.q.x, pose.q.y, pose.q.z).toRotationMatrix();
  out.translation() = eigen_of(pose.p);
  return out;
}

mapping::RigidPose pose_of(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return {{pose.translation().x(), pose.translation().y(), pose.translation().z()},
          rt::normalised(rt::Quaternion{q.w(), q.x(), q.y(), q.z()})};
}

std::uint64_t voxel_key(const Eigen::Vector3d& p, double edge_m) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t at = static_cast<std::int64_t>(std::floor(p[i] / edge_m)) + (std::int64_t{1} << 20);
    key = key << 21 | (static_cast<std::uint64_t>(at) & 0x1fffffu);
  }
  return key;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// A pose after a small turn (first three) and move in the map's frame; still a rotation after thousands.
Eigen::Isometry3d moved(const Vector6& x, const Eigen::Isometry3d& pose) {
  Eigen::Isometry3d small = Eigen::Isometry3d::Identity();
  const double angle = x.head<3>().norm();
  if (angle > 1e-12) small.linear() = Eigen::AngleAxisd(angle, x.head<3>() / angle).toRotationMatrix();
  small.translation() = x.tail<3>();
  Eigen::Isometry3d out = small * pose;
  out.linear() = Eigen::Quaterniond(out.linear()).normalized().toRotationMatrix();
  return out;
}

/// Of ten neighbours each.
std::vector<Eigen::Matrix3d> flat_covariances(const Vectors& points) {
  std::vector<Eigen::Matrix3d> out(points.size(), Eigen::Matrix3d::Identity());
#ifdef SORTIE_PEER_PCL
  constexpr int kNeighbours = 10;
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3d& p : points)
    cloud->push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(cloud);
  pcl::Indices near;
  std::vector<float> squared;
  for (std::size_t k = 0; k < points.size(); ++k) {
    tree.nearestKSearch((*cloud)[k], kNeighbours, near, squared);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (const int i : near) {
      const Eigen::Vector3d v = points[static_cast<std::size_t>(i)] - points[k];
      sum += v;
      products += v * v.transpose();
    }
    const double n = static_cast<double>(near.size());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(products / n -
                                                               sum * sum.transpose() / (n * n));
    out[k] =
        eigen.eigenvectors() * Eigen::Vector3d(1e-3, 1, 1).asDiagonal() * eigen.eigenvectors().transpose();
  }
#endif
  return out;
}

Vectors one_a_voxel(const Vectors& points, double edge_m) {
  std::unordered_map<std::uint64_t, bool> taken;
  Vectors out;
  for (const Eigen::Vector3d& p : points) {
    if (taken.emplace(voxel_key(p, edge_m), true).second) out.push_back(p);
  }
  return out;
}

}  // namespace

PeerPoints one_a_voxel(std::span<const rt::Vector3> points_m, double edge_m) {
  PeerPoints out;
  for (const Eigen::Vector3d& p : one_a_voxel(eigen_of(points_m), edge_m))
    out.push_back({p.x(), p.y(), p.z()});
  return out;
}

struct VoxelGicp::Inside {
  struct Voxel {
    Eigen::Vector3d sum{Eigen::Vector3d::Zero()};
    Eigen::Matrix3d covariances{Eigen::Matrix3d::Zero()};
    double n{};
  };
  std::unordered_map<std::uint64_t, Voxel> voxels;

  /// The error at a pose; with `h` also its equations.
  double look(const Vectors& scan, const std::vector<Eigen::Matrix3d>& covariances,
              const Eigen::Isometry3d& at, Matrix6* h, Vector6* b) const {
    double error = 0;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Eigen::Vector3d p = at * scan[i];
      const auto found = voxels.find(voxel_key(p, kGicpVoxel_m));
      if (found == voxels.end()) continue;
      const Voxel& voxel = found->second;
      const Eigen::Vector3d off = voxel.sum / voxel.n - p;
      if (off.norm() > kGicpReach_m) continue;
      const Eigen::Matrix3d weight =
          (voxel.covariances / voxel.n + at.linear() * covariances[i] * at.linear().transpose()).inverse();
      error += off.dot(weight * off);
      if (h == nullptr) continue;
      Eigen::Matrix<double, 3, 6> j;
      j << cross(p), -Eigen::Matrix3d::Identity();
      *h += j.transpose() * weight * j;
      *b += j.transpose() * weight * off;
    }
    return error;
  }
};

VoxelGicp::VoxelGicp() : inside_(std::make_unique<Inside>()) {}
VoxelGicp::~VoxelGicp() = default;
bool VoxelGicp::empty() const { return inside_->voxels.empty(); }

void VoxelGicp::add(std::span<const rt::Vector3> points_m) {
  const Vectors points = eigen_of(points_m);
  const std::vector<Eigen::Matrix3d> covariances = flat_covariances(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Inside::Voxel& voxel = inside_->voxels[voxel_key(points[i], kGicpVoxel_m)];
    voxel.sum += points[i];
    voxel.covariances += covariances[i];
    voxel.n += 1;
  }
}

mapping::RigidPose VoxelGicp::align(std::span<const rt::Vector3> scan_m,
                                    const mapping::RigidPose& start) const {
  const Vectors scan = eigen_of(scan_m);
  const std::vector<Eigen::Matrix3d> covariances = flat_covariances(scan);
  Eigen::Isometry3d pose = eigen_of(start);
  double lambda = 1e-3;
  for (int step = 0; step < 20; ++step) {
    Matrix6 h = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    const double error = inside_->look(scan, covariances, pose, &h, &b);
    Vector6 x = Vector6::Zero();
    for (int trial = 0; trial < 10; ++trial, lambda *= 10) {
      x = (h + lambda * Matrix6::Identity()).ldlt().solve(-b);
      const Eigen::Isometry3d next = moved(x, pose);
      if (!(inside_->look(scan, covariances, next, nullptr, nullptr) <= error)) continue;
      pose = next;
      lambda /= 10;
      break;
    }
    if (x.head<3>().norm() < 0.1 * M_PI / 180 && x.tail<3>().norm() < 1e-3) break;
  }
  return pose_of(pose);
}

struct KissIcp::Inside {
  std::unordered_map<std::uint64_t, Vectors> voxels;
  double voxel_m{};
  double range_m{};
  Eigen::Isometry3d pose{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d motion{Eigen::Isometry3d::Identity()};
  double off2{kFirstSigma_m * kFirstSigma_m};  ///< sum of squares of what constant motion was off by
  int offs{1};

  void add(const Vectors& points) {
    const double apart2 = voxel_m * voxel_m / static_cast<double>(kPointsOfVoxel);
    for (const Eigen::Vector3d& p : points) {
      Vectors& voxel = voxels[voxel_key(p, voxel_m)];
      const auto is_near = [&](const Eigen::Vector3d& q) { return (p - q).squaredNorm() < apart2; };
      if (voxel.size() < kPointsOfVoxel && std::none_of(voxel.begin(), voxel.end(), is_near))
        voxel.push_back(p);
    }
  }
  /// In the 27 voxels about; null: none within.
  const Eigen::Vector3d* nearest(const Eigen::Vector3d& p, double within_m, double& squared) const {
    const Eigen::Vector3d* found = nullptr;
    squared = within_m * within_m;
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3d beside(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      const auto voxel = voxels.find(voxel_key(p + voxel_m * beside, voxel_m));
      if (voxel == voxels.end()) continue;
      for (const Eigen::Vector3d& q : voxel->second) {
        if ((q - p).squaredNorm() >= squared) continue;
        squared = (q - p).squaredNorm();
        found = &q;
      }
    }
    return found;
  }
  Eigen::Isometry3d align(const Vectors& scan, Eigen::Isometry3d at, double sigma_m) const {
    const double kernel = sigma_m / 3.0;
    for (int step = 0; step < 500 && !voxels.empty(); ++step) {
      Matrix6 h = Matrix6::Zero();
      Vector6 b = Vector6::Zero();
      for (const Eigen::Vector3d& v : scan) {
        const Eigen::Vector3d p = at * v;
        double squared{};
        const Eigen::Vector3d* const q = nearest(p, 3 * sigma_m, squared);
        if (q == nullptr) continue;
        const double weight = std::pow(kernel / (kernel + squared), 2);
        Eigen::Matrix<double, 3, 6> j;
        j << -cross(p), Eigen::Matrix3d::Identity();
        h += weight * j.transpose() * j;
        b += weight * j.transpose() * (p - *q);
      }
      const Vector6 x = h.ldlt().solve(-b);
      if (!x.allFinite()) break;
      at = moved(x, at);
      if (x.norm() < 1e-4) break;
    }
    return at;
  }
};

KissIcp::KissIcp(double voxel_m, double range_m) : inside_(std::make_unique<Inside>()) {
  inside_->voxel_m = voxel_m;
  inside_->range_m = range_m;
}
KissIcp::~KissIcp() = default;

void KissIcp::add(std::span<const rt::Vector3> points_m) { inside_->add(eigen_of(points_m)); }

mapping::RigidPose KissIcp::align(std::span<const rt::Vector3> scan_m, const mapping::RigidPose& start,
                                  double sigma_m) const {
  return pose_of(inside_->align(eigen_of(scan_m), eigen_of(start), sigma_m));
}

mapping::RigidPose KissIcp::follow(std::span<const rt::Vector3> scan_m) {
  Inside& in = *inside_;
  Vectors within;
  for (const rt::Vector3& p : scan_m) {
    if (rt::norm(p) < in.range_m) within.push_back(eigen_of(p));
  }
  const Vectors for_map = one_a_voxel(within, 0.5 * in.voxel_m);
  const Eigen::Isometry3d expected = in.pose * in.motion;
  const Eigen::Isometry3d found =
      in.align(one_a_voxel(for_map, 1.5 * in.voxel_m), expected, std::sqrt(in.off2 / in.offs));
  const Eigen::Isometry3d off = expected.inverse() * found;
  const double turn = Eigen::AngleAxisd(off.linear()).angle();
  const double off_m = 2 * in.range_m * std::sin(0.5 * turn) + off.translation().norm();
  if (!in.voxels.empty() && off_m > 0.1) {
    in.off2 += off_m * off_m;
    ++in.offs;
  }
  in.motion = in.pose.inverse() * found;
  in.pose = found;
  Vectors placed;
  for (const Eigen::Vector3d& p : for_map) placed.emplace_back(in.pose * p);
  in.add(placed);
  for (auto it = in.voxels.begin(); it != in.voxels.end();) {
    const bool far = (it->second.front() - in.pose.translation()).norm() > in.range_m;
    it = far ? in.voxels.erase(it) : std::next(it);
  }
  return pose_of(in.pose);
}

}  // namespace sortie::bench
