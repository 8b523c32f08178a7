// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/deceptive_worlds.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/recognition/hall_things.hpp"

namespace sortie::bench {
namespace {
using testing::Draws;
using Way = std::vector<rt::Vector3>;

constexpr double kMargin_m = 0.4;  ///< between things
constexpr double kWay_m = 0.8;     ///< of the ways
constexpr double kStep_m = 0.4;
constexpr double kSensor_m = 0.6;

/// A hall whose things can be moved.
class Room {
 public:
  ThingHall hall;  ///< walls, and what cannot be moved

  Room(double half_x, double half_y, double height) {
    hall.half_x = half_x;
    hall.half_y = half_y;
    hall.height = height;
    hall.ceiling = true;
  }

  /// From one end to the other, at `y`, weaving.
  static Way way(double from_x, double to_x, double y, Draws& draws) {
    const double weave = draws.uniform(0.1, 0.3), turn = draws.uniform(0.4, 0.9);
    const double length = std::fabs(to_x - from_x), sign = to_x < from_x ? -1.0 : 1.0;
    Way way;
    for (int i = 0; i * kStep_m <= length; ++i)
      way.push_back({from_x + sign * i * kStep_m, y + weave * std::sin(turn * i * kStep_m), kSensor_m});
    return way;
  }
  /// Two ways through all of it, the second one from either end.
  void draw_ways(Draws& draws) {
    const double x = hall.half_x - 1.2;
    const double y = hall.half_y * draws.uniform(-0.3, 0.3);
    hall.way[0] = way(-x, x, y, draws);
    hall.way[1] = way(-x, x, y + draws.uniform(-1.0, 1.0), draws);
    if (draws.uniform(0, 1) < 0.5) std::reverse(hall.way[1].begin(), hall.way[1].end());
  }
  void furnish(int most, Draws& draws) {
    for (int tries = 0; tries < 20 * most && static_cast<int>(things_.size()) < most; ++tries) {
      const Thing thing = draw_thing(draws, hall.height);
      place(thing, draws);
    }
  }
  /// Each thing stands elsewhere with that probability, or is gone where there is no room.
  void move(double share, Draws& draws) {
    const std::vector<PlacedThing> before = things_;
    things_.clear();
    std::vector<Thing> moved;
    for (const PlacedThing& one : before) {
      if (draws.uniform(0, 1) < share) {
        moved.push_back(one.thing);
      } else {
        things_.push_back(one);
      }
    }
    for (const Thing& thing : moved) {
      for (int tries = 0; tries < 10 && !place(thing, draws); ++tries) {
      }
    }
  }
  ThingHall built() const {
    ThingHall out = hall;
    for (const PlacedThing& one : things_) put(out.solids, one.thing, one.at, one.yaw);
    return out;
  }

 private:
  struct PlacedThing {
    Thing thing;
    rt::Vector3 at;
    double yaw;
  };

  bool place(const Thing& thing, Draws& draws) {
    const rt::Vector3 at{draws.uniform(-hall.half_x, hall.half_x), draws.uniform(-hall.half_y, hall.half_y),
                         0};
    const double yaw = draws.uniform(0, 2 * M_PI);
    if (!is_free(at, thing.radius)) return false;
    things_.push_back({thing, at, yaw});
    return true;
  }
  bool is_free(const rt::Vector3& at, double radius) const {
    const double x = std::fabs(at.x) + radius + kMargin_m, y = std::fabs(at.y) + radius + kMargin_m;
    if (x > hall.half_x || y > hall.half_y) return false;
    const auto apart = [&](const rt::Vector3& other, double least) {
      return std::hypot(at.x - other.x, at.y - other.y) >= least;
    };
    const auto is_clear = [&](const PlacedThing& other) {
      return apart(other.at, radius + other.thing.radius + kMargin_m);
    };
    const auto is_off = [&](const rt::Vector3& p) { return apart(p, radius + kWay_m); };
    const auto misses = [&](const HallSolid& solid) {
      return apart(solid.foot, radius + std::hypot(solid.half_x, solid.half_y) + kMargin_m);
    };
    return std::all_of(things_.begin(), things_.end(), is_clear) &&
           std::all_of(hall.solids.begin(), hall.solids.end(), misses) &&
           std::all_of(hall.way[0].begin(), hall.way[0].end(), is_off) &&
           std::all_of(hall.way[1].begin(), hall.way[1].end(), is_off);
  }

  std::vector<PlacedThing> things_;
};

Room small_room(Draws& draws) {
  Room room(draws.uniform(5.5, 8.0), draws.uniform(4.5, 6.0), draws.uniform(2.6, 3.6));
  room.draw_ways(draws);
  return room;
}

/// `one` and `other` of one plan: both kept, the robot in either one; or only `one`, the robot in `other`.
RecognitionWorld twin_world(const Room& one, Room other, const mapping::RigidPose& T_world_other,
                            Draws& draws) {
  RecognitionWorld world;
  world.is_kept = draws.uniform(0, 1) < 0.5;
  world.moved = world.is_kept ? draws.uniform(0.0, 0.3) : draws.uniform(0.4, 0.7);
  other.move(world.moved, draws);
  world.kept.push_back({one.built(), {}});
  const HallAt second{other.built(), T_world_other};
  if (world.is_kept) world.kept.push_back(second);
  world.now = world.is_kept && draws.uniform(0, 1) < 0.5 ? world.kept[0] : second;
  return world;
}

RecognitionWorld twin_rooms(Draws& draws) {
  Room room = small_room(draws);
  room.furnish(static_cast<int>(draws.uniform(12, 24)), draws);
  const int quarters = static_cast<int>(draws.uniform(0, 4));
  const double across = 2.0 * std::max(room.hall.half_x, room.hall.half_y) + 0.5;
  return twin_world(room, room, {{0, across, 0}, rt::from_yaw_pitch_roll(0.5 * M_PI * quarters, 0, 0)},
                    draws);
}

RecognitionWorld twin_floors(Draws& draws) {
  Room room = small_room(draws);
  // Walls across, a gap in each for the ways.
  for (const double at : {-0.35, 0.35}) {
    const double x = at * room.hall.half_x, wide = draws.uniform(0.4, 0.8);
    for (const double side : {-1.0, 1.0})
      room.hall.solids.push_back(
          {{x, side * (room.hall.half_y - 0.5 * wide), 0}, 0.1, 0.5 * wide, room.hall.height});
  }
  room.furnish(static_cast<int>(draws.uniform(12, 24)), draws);
  return twin_world(room, room, {{0, 0, room.hall.height + 0.3}, {}}, draws);
}

RecognitionWorld mirror_world(Draws& draws) {
  Room room = small_room(draws);
  room.furnish(static_cast<int>(draws.uniform(12, 24)), draws);
  RecognitionWorld world;
  world.kept.push_back({room.built(), {}});
  world.now = world.kept[0];
  for (HallSolid& solid : world.now.hall.solids) {
    solid.foot.x = -solid.foot.x;
    solid.sine = -solid.sine;
  }
  for (auto& way : world.now.hall.way) {
    for (rt::Vector3& p : way) p.x = -p.x;
  }
  return world;
}

/// Both of one pattern: the same one, seen at its other end, or another one.
RecognitionWorld pattern_world(Room (*pattern)(double half_x, double half_y, Draws& draws), double half_x,
                               double half_y, Draws& draws) {
  RecognitionWorld world;
  world.is_kept = draws.uniform(0, 1) < 0.5;
  Draws same(static_cast<std::uint64_t>(draws.uniform(0, 1e9)));
  Draws again = same;
  const bool all = draws.uniform(0, 1) < 0.5;  // of it is kept
  const Room one = pattern(half_x, half_y, same);
  const Room other = pattern(half_x + draws.uniform(1.5, 4.5), half_y, again);
  const auto drive = [&](const Room& room, double from, double to) {
    HallAt at{room.hall, {}};
    const double x = room.hall.half_x - 1.5;
    for (auto& way : at.hall.way) way = Room::way(from * x, to * x, draws.uniform(-0.3, 0.3), draws);
    if (draws.uniform(0, 1) < 0.5) std::reverse(at.hall.way[1].begin(), at.hall.way[1].end());
    return at;
  };
  world.kept.push_back(drive(one, -1.0, all ? 1.0 : 0.0));
  const double from = draws.uniform(all ? -0.8 : -0.1, 0.2);
  world.now = drive(world.is_kept ? one : other, from, from + 0.7);
  return world;
}

/// Pillars where those of a grid are, from the middle outwards; an aisle in the middle.
Room pillar_hall(double half_x, double half_y, Draws& draws) {
  Room room(half_x, half_y, draws.uniform(2.8, 3.6));
  const double apart_x = draws.uniform(2.2, 3.6), apart_y = draws.uniform(2.4, 3.6);
  const double half = draws.uniform(0.15, 0.35);
  const bool round = draws.uniform(0, 1) < 0.3;
  for (double x = 0.5 * apart_x; x < half_x - 0.6; x += apart_x) {
    for (double y = 0.5 * apart_y; y < half_y - 0.6; y += apart_y) {
      for (int side = 0; side < 4; ++side) {
        HallSolid pillar{{side % 2 == 0 ? x : -x, side < 2 ? y : -y, 0}, half, half, room.hall.height};
        pillar.round = round;
        room.hall.solids.push_back(pillar);
      }
    }
  }
  return room;
}

/// Pilasters and the same few things in each period.
Room corridor(double half_x, double half_y, Draws& draws) {
  Room room(half_x, half_y, draws.uniform(2.5, 3.2));
  const double period = draws.uniform(1.8, 3.5), deep = draws.uniform(0.1, 0.2);
  struct Fixture {
    double x, y, half_x, half_y, height;
  };
  std::vector<Fixture> fixtures;
  for (const double side : {-1.0, 1.0}) {
    fixtures.push_back({0, side * (half_y - deep), draws.uniform(0.15, 0.3), deep, room.hall.height});
    if (draws.uniform(0, 1) < 0.7) {
      const double wide = draws.uniform(0.1, 0.2);
      fixtures.push_back({draws.uniform(0.35, 0.65) * period, side * (half_y - wide), draws.uniform(0.2, 0.5),
                          wide, draws.uniform(0.6, 2.0)});
    }
  }
  const int reach = static_cast<int>(half_x / period);
  for (int i = -reach; i <= reach; ++i) {
    for (const Fixture& one : fixtures) {
      const double x = i * period + one.x;
      if (std::fabs(x) + one.half_x < half_x - 0.2)
        room.hall.solids.push_back({{x, one.y, 0}, one.half_x, one.half_y, one.height});
    }
  }
  return room;
}

}  // namespace

const char* name_of(Deception kind) {
  constexpr const char* kNames[] = {"identical rooms", "pillar grid", "mirrored hall", "periodic corridor",
                                    "two floors alike"};
  return kNames[static_cast<int>(kind)];
}

RecognitionWorld deceptive_world(Deception kind, Draws& draws) {
  switch (kind) {
    case Deception::rooms:
      return twin_rooms(draws);
    case Deception::pillars:
      return pattern_world(pillar_hall, draws.uniform(8, 12), draws.uniform(5, 8), draws);
    case Deception::mirrored:
      return mirror_world(draws);
    case Deception::corridor:
      return pattern_world(corridor, draws.uniform(9, 14), draws.uniform(1.1, 1.7), draws);
    default:
      return twin_floors(draws);
  }
}

RecognitionWorld revisited_hall(SecondWay second, double moved, Draws& draws) {
  Room room(draws.uniform(14, 18), draws.uniform(5, 8), draws.uniform(2.8, 4.5));
  const double x = room.hall.half_x - 1.2, y = room.hall.half_y * draws.uniform(-0.3, 0.3);
  room.hall.way[0] = Room::way(-x, x, y, draws);
  room.hall.way[1] = Room::way(-x, x, y + draws.uniform(-2.0, 2.0), draws);
  if (second == SecondWay::against) std::reverse(room.hall.way[1].begin(), room.hall.way[1].end());
  room.furnish(static_cast<int>(2.0 * room.hall.half_x), draws);
  RecognitionWorld world;
  world.is_kept = true;
  world.moved = moved;
  world.kept.push_back({room.built(), {}});
  room.move(moved, draws);
  world.now = {room.built(), {}};
  return world;
}

HallLidar sparse_lidar(Draws& draws) {
  constexpr double kDeg = M_PI / 180.0;
  const double noise_m = draws.uniform(0.01, 0.03);
  if (draws.uniform(0, 1) < 0.5) return {16, 360, -15 * kDeg, 15 * kDeg, noise_m};
  return {32, 180, -25 * kDeg, 15 * kDeg, noise_m};
}

}  // namespace sortie::bench
