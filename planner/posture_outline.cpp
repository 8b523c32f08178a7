// SPDX-License-Identifier: BSD-3-Clause
#include "planner/posture_outline.hpp"

#include <algorithm>
#include <cmath>

#include "planner/posture_slice.hpp"

namespace sortie::planner {
namespace {

/// Normals of both runs of a slice: n . (c1 - c0) = r0 - r1 for a common tangent.
void set_runs(OutlineSlice& s) {
  const double dx = s.x_m[1] - s.x_m[0];
  const double dz = s.z_m[1] - s.z_m[0];
  const double length = std::sqrt(dx * dx + dz * dz);
  const double along = (s.radius_m[0] - s.radius_m[1]) / length;
  const double across = std::sqrt(std::max(0.0, 1.0 - along * along));
  const double x = dx / length;
  const double z = dz / length;
  for (int side = 0; side < 2; ++side) {
    const double turn = side == 0 ? across : -across;
    s.run_normal[side][0] = along * x + turn * z;
    s.run_normal[side][1] = along * z - turn * x;
  }
}

/// Height of the ground at any place over the patch: along a slope or at a step, as the patch itself has it.
class GroundReader {
 public:
  explicit GroundReader(const GroundPatch& ground)
      : ground_(ground), per_m_(1.0 / ground.spacing_m()), limit_(static_cast<float>(ground.spacing_m())) {}

  int first_column(double x) const { return static_cast<int>(rt::floor(x * per_m_)); }
  double column_x(int column) const { return ground_.spacing_m() * column; }

  /// The rows on both sides of a place, and its share of the way between them.
  struct Rows {
    int below{};
    float share{};
    bool inside{};
  };
  Rows rows(double y) const {
    const double row = y * per_m_;
    const auto below = static_cast<int>(rt::floor(row));
    return {below, static_cast<float>(row - below),
            below >= -GroundPatch::kHalfRows && below < GroundPatch::kHalfRows};
  }

  /// At a column. False where the patch ends or nothing is known.
  bool at_column(int column, const Rows& rows, double& height) const {
    if (column < -GroundPatch::kHalfColumns || column > GroundPatch::kHalfColumns || !rows.inside)
      return false;
    return between(ground_.height(column, rows.below), ground_.height(column, rows.below + 1), rows.share,
                   height);
  }

  /// Anywhere.
  bool at(double x, double y, double& height) const {
    const int column = first_column(x);
    const Rows place = rows(y);
    double low{};
    double high{};
    const bool has_low = at_column(column, place, low);
    const bool has_high = at_column(column + 1, place, high);
    const double share = x * per_m_ - column;
    if (!has_low && !has_high) return false;
    if (!has_low || !has_high) {
      height = has_low ? low : high;
      return has_low ? share <= 0.5 : share >= 0.5;
    }
    return between(static_cast<float>(low), static_cast<float>(high), static_cast<float>(share), height);
  }

 private:
  bool between(float a, float b, float share, double& height) const {
    float value = a + share * (b - a);
    if (!(std::fabs(a - b) <= limit_)) value = share < 0.5F ? a : share > 0.5F ? b : std::max(a, b);
    height = static_cast<double>(value);
    return value > 0.5F * GroundPatch::kUnknown;
  }

  const GroundPatch& ground_;
  double per_m_;
  float limit_;
};

void add_discs(rt::VehiclePart part, double y, const double (&x)[2], const double (&z)[2],
               const double (&radius)[2], Outline& outline, std::uint32_t& count) {
  OutlineSlice& s = outline[count++];
  for (int k = 0; k < 2; ++k) {
    s.x_m[k] = x[k];
    s.z_m[k] = z[k];
    s.radius_m[k] = radius[k];
  }
  s.y_m = y;
  s.part = part;
  set_runs(s);
}

}  // namespace

Outline outline_of(const PostureVehicle& v, const FlipperSet& flippers) {
  const estimators::TrackProfile& p = v.side;
  Outline outline;
  std::uint32_t count = 0;
  const auto flipper_slices = [&](int f, double y) {
    const double ahead = f < 2 ? 1.0 : -1.0;
    const rt::SinCos turn = rt::sincos(flippers.angle_rad[f]);
    const auto part = static_cast<rt::VehiclePart>(3 + f);
    add_discs(part, y, {ahead * p.pivot_x_m, ahead * (p.pivot_x_m + p.flipper_m * turn.cos)},
              {p.pivot_z_m, p.pivot_z_m + p.flipper_m * turn.sin}, {p.pivot_radius_m, p.tip_radius_m},
              outline, count);
  };
  const auto track_slices = [&](double side) {
    const auto part = side > 0.0 ? rt::VehiclePart::track_left : rt::VehiclePart::track_right;
    for (int k = -1; k <= 1; ++k)
      add_discs(part, side * p.half_width_m + 0.5 * k * v.track_width_m, {-p.half_length_m, p.half_length_m},
                {p.axle_m, p.axle_m}, {p.radius_m, p.radius_m}, outline, count);
  };
  const double half = 0.5 * v.flipper_width_m;
  for (int f : {1, 3}) {
    flipper_slices(f, -v.flipper_y_m - half);
    flipper_slices(f, -v.flipper_y_m + half);
  }
  track_slices(-1.0);
  for (int k = -2; k <= 2; ++k)
    add_discs(rt::VehiclePart::body, 0.5 * k * v.belly_half_width_m, {v.belly_rear_m, v.belly_front_m},
              {v.belly_z_m, v.belly_z_m}, {0.0, 0.0}, outline, count);
  track_slices(1.0);
  for (int f : {0, 2}) {
    flipper_slices(f, v.flipper_y_m - half);
    flipper_slices(f, v.flipper_y_m + half);
  }
  return outline;
}

rt::Vector3 centre_of_mass(const PostureVehicle& v, const FlipperSet& flippers) {
  rt::Vector3 centre{v.side.com_x_m, 0.0, v.side.com_z_m};
  const double share = v.flipper_mass_kg * v.flipper_com_m / v.mass_kg;
  double ahead = 0.0;
  double up = 0.0;
  for (int f = 0; f < 4; f += 2) {  // left and right are added first: so is it in the mirror image
    const rt::SinCos left = rt::sincos(flippers.angle_rad[f]);
    const rt::SinCos right = rt::sincos(flippers.angle_rad[f + 1]);
    const double forward = (left.cos - 1.0) + (right.cos - 1.0);
    ahead += f == 0 ? forward : -forward;
    up += left.sin + right.sin;
  }
  centre.x += share * ahead;
  centre.z += share * up;
  return centre;
}

namespace {

/// Places between the columns that matter: where the run ends, and where a disc would touch the slope below
/// it.
struct Extras {
  double x[4];
  int count{};

  void add(double at) {
    int k = count++;
    for (; k > 0 && x[k - 1] > at; --k) x[k] = x[k - 1];
    x[k] = at;
  }

  Extras(const TiltedSlice& slice, const GroundReader& reader, double spacing_m) {
    for (int k = 0; k < 2; ++k) {
      add(slice.run_x[k]);
      const double r = slice.radius[k];
      if (r == 0.0) continue;
      double at = slice.x[k];
      double ahead{};
      double behind{};
      const double reach = 0.5 * spacing_m;
      if (reader.at(at + reach, slice.y[k], ahead) && reader.at(at - reach, slice.y[k], behind)) {
        const double slope = (ahead - behind) / spacing_m;
        if (std::fabs(slope) <= 1.0) at += r * slope / std::sqrt(1.0 + slope * slope);
      }
      add(at);
    }
  }
};

/// The samples of a slice, from behind to ahead: of them only the corners of their upper hull are kept.
class SliceLifts {
 public:
  SliceLifts(Lifts& lifts, LiftCount& count) : lifts_(lifts), count_(count), begin_(lifts.size()) {}

  void add(const TiltedSlice& slice, std::uint32_t index, double x, double y, bool has_height,
           double height) {
    double bottom{};
    if (!slice.bottom(x, bottom)) return;
    ++count_.samples;
    if (!has_height) {
      ++count_.unknown;
      return;
    }
    const Lift lift{x, y, height - bottom, height, static_cast<std::uint8_t>(index)};
    while (lifts_.size() >= begin_ + 2) {
      const Lift& a = lifts_[lifts_.size() - 2];
      const Lift& b = lifts_[lifts_.size() - 1];
      if ((b.lift_m - a.lift_m) * (lift.x_m - a.x_m) > (lift.lift_m - a.lift_m) * (b.x_m - a.x_m)) break;
      lifts_.pop_back();
    }
    (void)lifts_.push_back(lift);
  }

 private:
  Lifts& lifts_;
  LiftCount& count_;
  std::uint32_t begin_;
};

}  // namespace

LiftCount lifts_at(const Outline& outline, const GroundPatch& ground, const Tilt& tilt, Lifts& lifts) {
  const GroundReader reader(ground);
  LiftCount count;
  lifts.clear();
  for (std::uint32_t index = 0; index < kOutlineSlices; ++index) {
    const TiltedSlice slice(outline[index], tilt);
    const Extras extras(slice, reader, ground.spacing_m());
    SliceLifts kept(lifts, count);
    int extra = 0;
    const auto add_extras = [&](double up_to) {
      for (; extra < extras.count && extras.x[extra] <= up_to; ++extra) {
        const double x = extras.x[extra];
        const double y = slice.y_at(x);
        double height{};
        const bool known = reader.at(x, y, height);
        kept.add(slice, index, x, y, known, height);
      }
    };
    GroundReader::Rows rows = reader.rows(slice.y[0]);
    const int last = reader.first_column(slice.end());
    for (int column = reader.first_column(slice.begin()) + 1; column <= last; ++column) {
      const double x = reader.column_x(column);
      add_extras(x);
      double y = slice.y[0];
      if (slice.y_slope != 0.0) {
        y = slice.y_at(x);
        rows = reader.rows(y);
      }
      double height{};
      const bool known = reader.at_column(column, rows, height);
      kept.add(slice, index, x, y, known, height);
    }
    add_extras(1e3);
  }
  return count;
}

}  // namespace sortie::planner
