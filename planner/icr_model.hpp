// SPDX-License-Identifier: BSD-3-Clause
// Skid steering by instantaneous centres of rotation: the body's twist to belt speeds and back.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/keys.hpp"

namespace sortie::planner {

/// Motion of the body's origin in the plane of the tracks, body frame (x forward, y left).
struct Twist {
  double v_x_m_s{};
  double v_y_m_s{};
  double w_rad_s{};
};

/// Speeds of the belts, positive forward.
struct TrackSpeeds {
  double left_m_s{};
  double right_m_s{};
};

/// Where the tracks and the body turn, body frame: the left belt moves over the ground as if it touched it
/// only at y_left, the right one at y_right, and the body's own centre of rotation lies at x (Martinez,
/// Mandow, Morales, Pedraza, Garcia-Cerezo 2005: v_x = (r y_l - l y_r) / (y_l - y_r), w = (r - l) /
/// (y_l - y_r), v_y = -w x). y_left > y_right. Without slip they are the tracks' centre lines; a track that
/// must be dragged sideways moves them outward.
struct IcrModel {
  double x_m{};
  double y_left_m{0.2};
  double y_right_m{-0.2};

  /// From the distance of the tracks and the steering efficiency (distance of the tracks / distance of their
  /// turning centres, above 0), the turning centres moved to the left by `y_m`.
  static IcrModel from_efficiency(double track_distance_m, double efficiency, double x_m = 0.0,
                                  double y_m = 0.0) {
    const double half = 0.5 * track_distance_m / efficiency;
    return {x_m, y_m + half, y_m - half};
  }

  /// Belt speeds that move the body with these speeds. v_y is no choice: it follows from w.
  TrackSpeeds to_tracks(double v_x_m_s, double w_rad_s) const {
    return {v_x_m_s - y_left_m * w_rad_s, v_x_m_s - y_right_m * w_rad_s};
  }

  /// The motion that belt speeds make.
  Twist to_twist(const TrackSpeeds& tracks) const {
    const double span = y_left_m - y_right_m;
    const double w = (tracks.right_m_s - tracks.left_m_s) / span;
    const double v = (tracks.right_m_s * y_left_m - tracks.left_m_s * y_right_m) / span;
    return {v, -w * x_m, w};
  }

  /// Belt speed that a turn rate of 1 rad/s takes at most: |l|, |r| <= |v| + lever() |w|. With centres that
  /// lie evenly about the body this is an equality for the faster track.
  double lever_m() const { return std::max(std::fabs(y_left_m), std::fabs(y_right_m)); }
};

/// The same as it is measured and written. A new distance of the tracks comes to set_track_width() as that of
/// their turning centres.
struct WrittenIcr {
  double track_width_m{0.4};
  double efficiency{1.0};
  double x_m{};
  double y_m{};

  IcrModel model() const { return IcrModel::from_efficiency(track_width_m, efficiency, x_m, y_m); }

  SORTIE_KEYS(c, key) {
    key("track_width_m", c.track_width_m,
        {0.05, 10, "m", "distance of the tracks, or of their turning centres with efficiency 1"},
        [widening = 1.0 / c.efficiency](auto& drive, double value) {
          return drive.set_track_width(widening * value);
        });
    key("steering_efficiency", c.efficiency,
        {0.05, 1, "", "distance of the tracks / distance of their turning centres"});
    key("turning_centre_x_m", c.x_m, {-10, 10, "m", "forward place of the body's turning centre"});
    key("turning_centre_y_m", c.y_m,
        {-0.02, 0.02, "m", "middle of the tracks' turning centres, to the left"});
  }
};

}  // namespace sortie::planner
