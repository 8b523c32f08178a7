// SPDX-License-Identifier: BSD-3-Clause
// The cell filter of ANYbotics' elevation_mapping, made again from its description (Fankhauser et al. 2014,
// 2018, and the published parameters): one height and one variance a cell.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/grid/sensor_pose.hpp"
#include "rt/samples.hpp"

namespace sortie::bench {

/// Parameters of the peer, its defaults, but for the size.
struct PeerFilterConfig {
  std::int32_t size{256};
  double cell_m{0.05};
  float least_variance_m2{9e-6f};
  float most_variance_m2{0.01f};
  float gate{2.5f};  ///< standard deviations
  float multi_height_noise_m2{9e-7f};
  double scanning_duration_s{1.0};
  // Of a laser: minimal radius, beam angle and constant.
  float least_radius_m{0.018f};
  float beam_angle_rad{0.0006f};
  float beam_constant_m{0.0015f};
};

/// Layers of floats, as a grid map keeps them; the layers of colour and of the visibility check are left out,
/// and so are that check and the fusion over neighbours, which make the peer dearer.
class PeerFilter {
 public:
  explicit PeerFilter(const PeerFilterConfig& config);
  /// The window's middle follows; cells that come in are emptied.
  void move(double x_m, double y_m);
  /// Variance of motion to every cell, and the clean-up to the limits that follows it.
  void predict(float variance_m2);
  /// The returns of a scan: each is placed, gets its variance from range and attitude, and is fused.
  void add(const rt::PointScan& scan, const mapping::SensorPose& pose, double now_s);
  /// Height of a place; false where there is none.
  bool height(double x_m, double y_m, double& height_m) const;

 private:
  bool index(double x_m, double y_m, std::size_t& at) const;
  void clean();

  PeerFilterConfig config_;
  double middle_[2]{};
  std::vector<float> elevation_;
  std::vector<float> variance_;
  std::vector<float> horizontal_x_;
  std::vector<float> horizontal_y_;
  std::vector<float> horizontal_xy_;
  std::vector<float> time_;
};

}  // namespace sortie::bench
