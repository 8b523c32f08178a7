// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/swept_check.hpp"

#include <algorithm>
#include <cmath>

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

// Does the line pass the box, grown by the robot's radii? A cheap no for most boxes beside a slanted line.
bool line_meets(const rt::Vector3& a, const rt::Vector3& d, const Bounds& box, const rt::Vector3& grow) {
  double first = 0.0;
  double last = 1.0;
  const double from[3] = {a.x, a.y, a.z};
  const double way[3] = {d.x, d.y, d.z};
  const double low[3] = {box.low.x - grow.x, box.low.y - grow.y, box.low.z - grow.z};
  const double high[3] = {box.high.x + grow.x, box.high.y + grow.y, box.high.z + grow.z};
  for (int i = 0; i < 3; ++i) {
    if (way[i] == 0.0) {
      if (from[i] < low[i] || from[i] > high[i]) return false;
      continue;
    }
    const double one = (low[i] - from[i]) / way[i];
    const double other = (high[i] - from[i]) / way[i];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  return first <= last;
}

// A part of the line, 0 at its start and 1 at its end; empty where `first` is greater.
struct Part {
  double first{0.0};
  double last{1.0};
};

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
    const double low = origin + brick * i - slack();
    const double high = origin + brick * (i + 1) + slack();
    if (way == 0.0) return from < low || from > high ? Part{1.0, 0.0} : part;
    const double one = (low - from) / way;
    const double other = (high - from) / way;
    return {std::max(part.first, std::min(one, other)), std::min(part.last, std::max(one, other))};
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

}  // namespace

void SweptWalk::begin(const rt::Vector3& a_m, const rt::Vector3& b_m, double share) {
  a_m_ = a_m;
  b_m_ = b_m;
  share_ = share;
  for (std::int32_t& next : next_) next = 0;
  result_ = {};
}

bool SweptWalk::run(const FlightMap& map, std::uint64_t& steps) {
  const FlightMapConfig& config = map.config();
  const rt::Vector3 r = share_ * config.radii_m;
  const double h = config.voxel_m;
  const rt::Vector3 margin{r.x + 1e-9, r.y + 1e-9, r.z + 1e-9};
  if (map.usable() != Status::ok || !rt::is_finite(a_m_) || !rt::is_finite(b_m_)) return ended(false);
  Bounds swept{{std::min(a_m_.x, b_m_.x), std::min(a_m_.y, b_m_.y), std::min(a_m_.z, b_m_.z)},
               {std::max(a_m_.x, b_m_.x), std::max(a_m_.y, b_m_.y), std::max(a_m_.z, b_m_.z)}};
  swept = {swept.low - margin, swept.high + margin};
  const rt::Vector3 top{config.origin_m.x + h * config.nx, config.origin_m.y + h * config.ny,
                        config.origin_m.z + h * config.nz};
  if (swept.low.x < config.origin_m.x || swept.low.y < config.origin_m.y || swept.low.z < config.origin_m.z ||
      swept.high.x > top.x || swept.high.y > top.y || swept.high.z > top.z)
    return ended(false);
  rt::convex::Convex robot = rt::convex::make_swept_ellipsoid(r, 0.5 * (b_m_ - a_m_));
  robot.p_world_m = 0.5 * (a_m_ + b_m_);
  rt::convex::Convex voxel = rt::convex::make_box({0.5 * h, 0.5 * h, 0.5 * h});
  rt::convex::Convex brick = rt::convex::make_box({2 * h, 2 * h, 2 * h});
  const auto use = [&steps](std::uint64_t used) { steps -= std::min(steps, used); };
  const auto is_hit = [&](rt::convex::Convex& body, const rt::Vector3& middle) {
    body.p_world_m = middle;
    ++result_.queries;
    use(kPair);
    return rt::convex::is_collision(rt::convex::query(robot, body).state);
  };
  const Voxel3 low = map.voxel_at(swept.low);
  const Voxel3 high = map.voxel_at(swept.high);
  const rt::Vector3 way = b_m_ - a_m_;
  const Axis along_x{
      a_m_.x, way.x, margin.x, config.origin_m.x, 4 * h, {low.x / 4, std::min(high.x / 4, map.bx() - 1)}};
  const Axis along_y{
      a_m_.y, way.y, margin.y, config.origin_m.y, 4 * h, {low.y / 4, std::min(high.y / 4, map.by() - 1)}};
  const Axis along_z{
      a_m_.z, way.z, margin.z, config.origin_m.z, 4 * h, {low.z / 4, std::min(high.z / 4, map.bz() - 1)}};
  // Layer by layer, row by row, only as far as the line goes there: not all of the box around it. From where
  // the slice before ended.
  for (std::int32_t z = std::max(along_z.all.low, next_[2]); z <= along_z.all.high; ++z) {
    const Part layer = along_z.beside({}, z);
    const bool same_layer = z == next_[2];
    if (layer.first <= layer.last) {
      const Bricks rows = along_y.along(layer);
      for (std::int32_t y = same_layer ? std::max(rows.low, next_[1]) : rows.low; y <= rows.high; ++y) {
        const Part row = along_y.beside(layer, y);
        const bool same_row = same_layer && y == next_[1];
        const Bricks near = row.first <= row.last ? along_x.along(row) : Bricks{0, -1};
        for (std::int32_t x = same_row ? std::max(near.low, next_[0]) : near.low; x <= near.high; ++x) {
          if (steps == 0) {
            next_[0] = x;
            next_[1] = y;
            next_[2] = z;
            return false;
          }
          use(1);
          ++result_.bricks;
          const Voxel3 corner{4 * x, 4 * y, 4 * z};
          const BrickMask blocked = map.blocked_brick(map.brick_of(corner));
          if (blocked == 0) continue;
          const rt::Vector3 middle = map.middle_m(corner) + rt::Vector3{1.5 * h, 1.5 * h, 1.5 * h};
          const rt::Vector3 two{2 * h, 2 * h, 2 * h};
          if (!line_meets(a_m_, way, {middle - two, middle + two}, margin)) continue;
          if (blocked == kWholeBrick) {
            if (is_hit(brick, middle)) return ended(false);
            continue;
          }
          use(kCloser);
          for (int bit = 0; bit < 64; ++bit) {
            if ((blocked >> bit & 1u) == 0) continue;
            const rt::Vector3 m =
                map.middle_m({corner.x + (bit & 3), corner.y + (bit >> 2 & 3), corner.z + (bit >> 4)});
            const rt::Vector3 half{0.5 * h, 0.5 * h, 0.5 * h};
            const Bounds box{m - half, m + half};
            if (overlap(swept, box) && line_meets(a_m_, way, box, margin) && is_hit(voxel, m))
              return ended(false);
          }
        }
        use(1);
      }
    }
    use(1);
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

SweptCheck check_swept(const FlightMap& map, const rt::Vector3& a_m, const rt::Vector3& b_m) {
  SweptWalk walk;
  walk.begin(a_m, b_m);
  std::uint64_t steps = UINT64_MAX;
  static_cast<void>(walk.run(map, steps));  // so much ends every line
  return walk.result();
}

}  // namespace sortie::planner
