// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/swept_check.hpp"

#include <algorithm>
#include <array>

#include "rt/convex/query.hpp"

namespace sortie::planner {
namespace {

constexpr std::int32_t kMostBricks = 256;  // along an axis of the largest map
constexpr std::uint32_t kMostLines = 64;   // of a way

struct Bounds {
  rt::Vector3 low;
  rt::Vector3 high;
};

bool overlap(const Bounds& a, const Bounds& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

// A part of the line, 0 at its start and 1 at its end; empty where `first` is greater.
struct Part {
  double first{0.0};
  double last{1.0};

  bool empty() const { return !(first <= last); }
  // What of it lies between two places of an axis, along which the line goes `way` from `from`.
  Part between(double low, double high, double from, double way) const {
    if (way == 0.0) return from < low || from > high ? Part{1.0, 0.0} : *this;
    const double one = (low - from) / way;
    const double other = (high - from) / way;
    return {std::max(first, std::min(one, other)), std::min(last, std::max(one, other))};
  }
};

// Does the line pass the box, grown by the robot's radii? A cheap no for most boxes beside a slanted line.
bool line_meets(const rt::Vector3& a, const rt::Vector3& d, const Bounds& box, const rt::Vector3& grow) {
  const Part part = Part{}
                        .between(box.low.x - grow.x, box.high.x + grow.x, a.x, d.x)
                        .between(box.low.y - grow.y, box.high.y + grow.y, a.y, d.y)
                        .between(box.low.z - grow.z, box.high.z + grow.z, a.z, d.z);
  return !part.empty();
}

// Bricks from the map's low corner along one axis.
struct Bricks {
  std::int32_t low;
  std::int32_t high;
};

// One axis: the line, the robot's radius, and where the bricks lie.
struct Axis {
  double from;
  double way;
  double radius;
  double origin;
  double brick;  // length of its edge
  Bricks all;    // that the swept box touches

  // Rounding is far below: what meets the line is never left out.
  double slack() const { return radius + 1e-6 * brick; }
  // The part of `part` along which the robot may touch brick number `i`.
  Part beside(const Part& part, std::int32_t i) const {
    return part.between(origin + brick * i - slack(), origin + brick * (i + 1) + slack(), from, way);
  }
  // The bricks that the robot may touch along a part that is not empty.
  Bricks along(const Part& part) const {
    const double a = from + way * part.first;
    const double b = from + way * part.last;
    const double low = (std::min(a, b) - slack() - origin) / brick;
    const double high = (std::max(a, b) + slack() - origin) / brick;
    return {std::max(all.low, static_cast<std::int32_t>(std::max(low, 0.0))),
            std::min(all.high, static_cast<std::int32_t>(std::max(high, 0.0)))};
  }
};

// The robot along one line, and the shapes that it is held against.
class Sweep {
 public:
  Sweep(const FlightMap& map, const rt::Vector3& a_m, const rt::Vector3& b_m, double share,
        SweptCheck& result, std::uint64_t& steps)
      : map_(map), h_(map.config().voxel_m), a_m_(a_m), way_m_(b_m - a_m), result_(result), steps_(steps) {
    const rt::Vector3 r = share * map.config().radii_m;
    margin_ = {r.x + 1e-9, r.y + 1e-9, r.z + 1e-9};
    const rt::Vector3 low{std::min(a_m.x, b_m.x), std::min(a_m.y, b_m.y), std::min(a_m.z, b_m.z)};
    const rt::Vector3 high{std::max(a_m.x, b_m.x), std::max(a_m.y, b_m.y), std::max(a_m.z, b_m.z)};
    swept_ = {low - margin_, high + margin_};
    robot_ = rt::convex::make_swept_ellipsoid(r, 0.5 * (b_m - a_m));
    robot_.p_world_m = 0.5 * (a_m + b_m);
    voxel_ = rt::convex::make_box({0.5 * h_, 0.5 * h_, 0.5 * h_});
    brick_ = rt::convex::make_box({2 * h_, 2 * h_, 2 * h_});
  }

  // All of the way lies within the map.
  bool is_inside() const {
    const FlightMapConfig& config = map_.config();
    const rt::Vector3 top{config.origin_m.x + h_ * config.nx, config.origin_m.y + h_ * config.ny,
                          config.origin_m.z + h_ * config.nz};
    return !(swept_.low.x < config.origin_m.x || swept_.low.y < config.origin_m.y ||
             swept_.low.z < config.origin_m.z || swept_.high.x > top.x || swept_.high.y > top.y ||
             swept_.high.z > top.z);
  }
  // x, y and z of a way within the map.
  std::array<Axis, 3> axes() const {
    const FlightMapConfig& c = map_.config();
    const rt::Vector3& origin = c.origin_m;
    const Voxel3 low = map_.voxel_at(swept_.low);
    const Voxel3 high = map_.voxel_at(swept_.high);
    const double edge = 4 * h_;
    return {Axis{a_m_.x, way_m_.x, margin_.x, origin.x, edge, {low.x / 4, std::min(high.x, c.nx - 1) / 4}},
            Axis{a_m_.y, way_m_.y, margin_.y, origin.y, edge, {low.y / 4, std::min(high.y, c.ny - 1) / 4}},
            Axis{a_m_.z, way_m_.z, margin_.z, origin.z, edge, {low.z / 4, std::min(high.z, c.nz - 1) / 4}}};
  }
  void use(std::uint64_t steps) { steps_ -= std::min(steps_, steps); }
  // The robot may touch something in the brick whose low corner this is.
  bool hits_in(const Voxel3& corner) {
    use(1);
    ++result_.bricks;
    const BrickMask blocked = map_.blocked_brick(map_.brick_of(corner));
    if (blocked == 0) return false;
    const rt::Vector3 middle = map_.middle_m(corner) + rt::Vector3{1.5 * h_, 1.5 * h_, 1.5 * h_};
    const rt::Vector3 two{2 * h_, 2 * h_, 2 * h_};
    if (!line_meets(a_m_, way_m_, {middle - two, middle + two}, margin_)) return false;
    if (blocked == kWholeBrick) return hits(brick_, middle);
    use(SweptWalk::kCloser);
    for (int bit = 0; bit < 64; ++bit) {
      if ((blocked >> bit & 1u) == 0) continue;
      const rt::Vector3 m = map_.middle_m(brick_voxel(corner, bit));
      const rt::Vector3 half{0.5 * h_, 0.5 * h_, 0.5 * h_};
      const Bounds box{m - half, m + half};
      if (overlap(swept_, box) && line_meets(a_m_, way_m_, box, margin_) && hits(voxel_, m)) return true;
    }
    return false;
  }

 private:
  bool hits(rt::convex::Convex& body, const rt::Vector3& middle_m) {
    body.p_world_m = middle_m;
    ++result_.queries;
    use(SweptWalk::kPair);
    return rt::convex::is_collision(rt::convex::query(robot_, body).state);
  }

  const FlightMap& map_;
  double h_;  // edge of a voxel
  rt::Vector3 a_m_;
  rt::Vector3 way_m_;
  rt::Vector3 margin_;
  Bounds swept_{};  // box around the way
  rt::convex::Convex robot_;
  rt::convex::Convex voxel_;
  rt::convex::Convex brick_;
  SweptCheck& result_;
  std::uint64_t& steps_;
};

}  // namespace

void SweptWalk::begin(const rt::Vector3& a_m, const rt::Vector3& b_m, double share) {
  a_m_ = a_m;
  b_m_ = b_m;
  share_ = share;
  for (std::int32_t& next : next_) next = 0;
  result_ = {};
}

bool SweptWalk::run(const FlightMap& map, std::uint64_t& steps) {
  if (map.usable() != Status::ok || !rt::is_finite(a_m_) || !rt::is_finite(b_m_)) return ended(false);
  Sweep sweep(map, a_m_, b_m_, share_, result_, steps);
  if (!sweep.is_inside()) return ended(false);
  const auto [along_x, along_y, along_z] = sweep.axes();
  // Layer by layer, row by row, only as far as the line goes there: not all of the box around it. From where
  // the slice before ended.
  for (std::int32_t z = std::max(along_z.all.low, next_[2]); z <= along_z.all.high; ++z) {
    const Part layer = along_z.beside({}, z);
    const bool same_layer = z == next_[2];
    const Bricks rows = layer.empty() ? Bricks{0, -1} : along_y.along(layer);
    for (std::int32_t y = same_layer ? std::max(rows.low, next_[1]) : rows.low; y <= rows.high; ++y) {
      const Part row = along_y.beside(layer, y);
      const bool same_row = same_layer && y == next_[1];
      const Bricks near = row.empty() ? Bricks{0, -1} : along_x.along(row);
      for (std::int32_t x = same_row ? std::max(near.low, next_[0]) : near.low; x <= near.high; ++x) {
        if (steps == 0) {
          next_[0] = x;
          next_[1] = y;
          next_[2] = z;
          return false;
        }
        if (sweep.hits_in({4 * x, 4 * y, 4 * z})) return ended(false);
      }
      sweep.use(1);
    }
    sweep.use(1);
  }
  return ended(true);
}

bool WayWalk::run(const FlightMap& map, std::span<const rt::Vector3> way_m, std::uint64_t& steps) {
  while (line_ + 1 < way_m.size()) {
    if (steps == 0) return false;
    if (!begun_) walk_.begin(way_m[line_], way_m[line_ + 1], share_);
    begun_ = true;
    if (!walk_.run(map, steps)) return false;
    begun_ = false;
    ++line_;
    if (!walk_.result().is_free) return true;
  }
  is_free_ = true;
  return true;
}

void SweptWalk::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "swept walk").state(a_m_, b_m_, share_, next_, result_);
  if (!archive.is_reading()) return;
  bool fits = share_ > 0.0 && share_ <= 1.0;
  for (const std::int32_t next : next_) fits = fits && next >= 0 && next <= kMostBricks;
  if (!fits) archive.fail(Status::malformed, "a line that is half judged");
}

void WayWalk::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "way walk").by_hand(line_).state(walk_, share_, begun_, is_free_);
  archive.bounded(line_, kMostLines);
  if (archive.is_reading() && !(share_ > 0.0 && share_ <= 1.0))
    archive.fail(Status::malformed, "a share of the robot's size");
}

}  // namespace sortie::planner
