// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/bare_worlds.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::bench {
namespace {
using testing::Draws;
using Way = std::vector<rt::Vector3>;

constexpr double kStep_m = 0.4;
constexpr double kSensor_m = 0.6;
constexpr double kDeep_m = 0.6;  ///< of a corridor's walls, in which niches are

/// Sizes that two worlds of a kind have in common.
struct BareSizes {
  double half_x{}, half_y{}, wide{}, height{};
  bool ceiling{};
};

/// Along the middle of a polyline, weaving to its left and right.
Way weave(const Way& corners, double beside, Draws& draws) {
  const double swing = draws.uniform(0.05, 0.25), turn = draws.uniform(0.4, 0.9);
  Way way;
  double gone = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const rt::Vector3 leg = corners[i] - corners[i - 1];
    const double length = rt::norm(leg);
    const rt::Vector3 ahead = (1.0 / length) * leg, left{-ahead.y, ahead.x, 0.0};
    for (double at = 0.0; at < length; at += kStep_m, gone += kStep_m)
      way.push_back(corners[i - 1] + at * ahead + (beside + swing * std::sin(turn * gone)) * left);
  }
  return way;
}

/// A wall along x from `from` to `to` whose face looks to `side`, at `face`: blocks with niches between them.
void niche_wall(ThingHall& hall, double from, double to, double face, double side, bool along_y,
                Draws& draws) {
  const auto block = [&](double begin, double end, double deep) {
    if (end - begin < 0.02 || deep < 0.01) return;
    HallSolid solid;
    const double middle = 0.5 * (begin + end), across = face - side * (kDeep_m - 0.5 * deep);
    solid.foot = along_y ? rt::Vector3{across, middle, 0} : rt::Vector3{middle, across, 0};
    solid.half_x = along_y ? 0.5 * deep : 0.5 * (end - begin);
    solid.half_y = along_y ? 0.5 * (end - begin) : 0.5 * deep;
    solid.height = hall.height;
    hall.solids.push_back(solid);
  };
  double at = from;
  while (at < to) {
    const double wall = std::min(at + draws.uniform(1.2, 5.0), to);
    block(at, wall, kDeep_m);
    const double end = std::min(wall + draws.uniform(0.7, 1.8), to);
    block(wall, end, kDeep_m - draws.uniform(0.15, 0.6));
    at = end;
  }
}

ThingHall frame_of(const BareSizes& sizes) {
  ThingHall hall;
  hall.half_x = sizes.half_x;
  hall.half_y = sizes.half_y;
  hall.height = sizes.height;
  hall.ceiling = sizes.ceiling;
  return hall;
}

ThingHall corridor(const BareSizes& sizes, Draws& draws) {
  ThingHall hall = frame_of(sizes);
  for (const double side : {-1.0, 1.0})
    niche_wall(hall, -hall.half_x, hall.half_x, -side * (hall.half_y - kDeep_m), side, false, draws);
  return hall;
}

/// Along the lower and the right side of its frame.
ThingHall bend(const BareSizes& sizes, Draws& draws) {
  ThingHall hall = frame_of(sizes);
  const double inner_x = hall.half_x - kDeep_m - sizes.wide, inner_y = -hall.half_y + kDeep_m + sizes.wide;
  // What is not corridor, but for the depth of its walls.
  HallSolid rest;
  const double right = inner_x - kDeep_m, low = inner_y + kDeep_m;
  rest.foot = {0.5 * (right - hall.half_x), 0.5 * (low + hall.half_y), 0};
  rest.half_x = 0.5 * (right + hall.half_x);
  rest.half_y = 0.5 * (hall.half_y - low);
  rest.height = hall.height;
  hall.solids.push_back(rest);
  niche_wall(hall, -hall.half_x, hall.half_x, -hall.half_y + kDeep_m, 1.0, false, draws);
  niche_wall(hall, -hall.half_x, inner_x, inner_y, -1.0, false, draws);
  niche_wall(hall, -hall.half_y, hall.half_y, hall.half_x - kDeep_m, -1.0, true, draws);
  niche_wall(hall, inner_y, hall.half_y, inner_x, 1.0, true, draws);
  return hall;
}

/// A wall that winds along x, on the left for 1: thin blocks end to end, each a little turned to the next.
void winding_wall(ThingHall& hall, double wide, double side, Draws& draws) {
  constexpr double kBlock_m = 0.5, kThick_m = 0.4;
  double swing[3], wave[3], phase[3];
  for (int i = 0; i < 3; ++i) {
    swing[i] = draws.uniform(0.15, 0.45);
    wave[i] = 2 * M_PI / draws.uniform(4, 12);
    phase[i] = draws.uniform(-M_PI, M_PI);
  }
  const auto face = [&](double x) {
    double y = 0.5 * wide + 0.4;
    for (int i = 0; i < 3; ++i) y += swing[i] * std::sin(wave[i] * x + phase[i]);
    return side * std::max(y, 0.8);
  };
  for (double x = -hall.half_x; x < hall.half_x; x += kBlock_m) {
    const double rise = face(x + kBlock_m) - face(x), length = std::hypot(kBlock_m, rise);
    HallSolid one;
    one.cosine = kBlock_m / length;
    one.sine = rise / length;
    // Its inner face runs through both ends.
    const double out = side * 0.5 * kThick_m;
    one.foot = {x + 0.5 * kBlock_m - out * one.sine, 0.5 * (face(x) + face(x + kBlock_m)) + out * one.cosine,
                0};
    one.half_x = 0.5 * length + 0.05;
    one.half_y = 0.5 * kThick_m;
    one.height = hall.height;
    hall.solids.push_back(one);
  }
}

ThingHall tunnel(const BareSizes& sizes, Draws& draws) {
  ThingHall hall = frame_of(sizes);
  for (const double side : {-1.0, 1.0}) winding_wall(hall, sizes.wide, side, draws);
  return hall;
}

ThingHall empty_hall(const BareSizes& sizes, int pillars, Draws& draws) {
  ThingHall hall = frame_of(sizes);
  for (int wall = 0; wall < 4; ++wall) {
    const bool along_y = wall >= 2;
    const double half = along_y ? hall.half_y : hall.half_x, side = wall % 2 == 0 ? -1.0 : 1.0;
    for (double at = -half + draws.uniform(1.0, 4.0); at < half - 1.0; at += draws.uniform(2.0, 7.0)) {
      const double deep = draws.uniform(0.1, 0.3), wide = draws.uniform(0.15, 0.6);
      const double across = side * ((along_y ? hall.half_x : hall.half_y) - deep);
      HallSolid one;
      one.foot = along_y ? rt::Vector3{across, at, 0} : rt::Vector3{at, across, 0};
      one.half_x = along_y ? deep : wide;
      one.half_y = along_y ? wide : deep;
      one.height = hall.height;
      hall.solids.push_back(one);
    }
  }
  for (int i = 0; i < pillars; ++i) {
    HallSolid one;
    one.foot = {draws.uniform(-0.9, 0.9) * hall.half_x, draws.uniform(0.35, 0.9) * hall.half_y, 0};
    if (draws.uniform(0, 1) < 0.5) one.foot.y = -one.foot.y;
    one.half_x = one.half_y = draws.uniform(0.15, 0.4);
    one.height = hall.height;
    one.round = draws.uniform(0, 1) < 0.5;
    hall.solids.push_back(one);
  }
  return hall;
}

BareSizes sizes_of(BareKind kind, Draws& draws) {
  BareSizes sizes;
  sizes.height = draws.uniform(2.4, 3.2);
  sizes.ceiling = true;
  sizes.wide = draws.uniform(1.8, 3.0);
  switch (kind) {
    case BareKind::corridor:
    case BareKind::plain:
      sizes.half_x = draws.uniform(15, 22);
      sizes.half_y = 0.5 * sizes.wide + kDeep_m;
      break;
    case BareKind::winding:
      sizes.half_x = draws.uniform(15, 22);
      sizes.half_y = 0.5 * sizes.wide + 2.5;
      break;
    case BareKind::bend:
      sizes.half_x = draws.uniform(9, 13);
      sizes.half_y = draws.uniform(9, 13);
      break;
    default:
      sizes.half_x = draws.uniform(8, 15);
      sizes.half_y = draws.uniform(5, 9);
      sizes.height = draws.uniform(3.0, 5.0);
      sizes.ceiling = draws.uniform(0, 1) < 0.5;
  }
  return sizes;
}

ThingHall built(BareKind kind, const BareSizes& sizes, Draws& draws) {
  switch (kind) {
    case BareKind::corridor:
      return corridor(sizes, draws);
    case BareKind::bend:
      return bend(sizes, draws);
    case BareKind::winding:
      return tunnel(sizes, draws);
    case BareKind::plain:
      return frame_of(sizes);
    default:
      return empty_hall(sizes, kind == BareKind::pillars ? static_cast<int>(draws.uniform(4, 10)) : 0, draws);
  }
}

/// The first way from end to end, the second one from somewhere on its first half to the end, 16 m at most.
void draw_ways(BareKind kind, const BareSizes& sizes, bool against, ThingHall& hall, Draws& draws) {
  Way corners{{-hall.half_x + 1.5, 0, kSensor_m}, {hall.half_x - 1.5, 0, kSensor_m}};
  double aside = 0.15 * (sizes.wide - 1.2);
  if (kind == BareKind::bend) {
    const double x = hall.half_x - kDeep_m - 0.5 * sizes.wide, y = -hall.half_y + kDeep_m + 0.5 * sizes.wide;
    corners = {{-hall.half_x + 1.5, y, kSensor_m}, {x, y, kSensor_m}, {x, hall.half_y - 1.5, kSensor_m}};
  } else if (kind == BareKind::hall || kind == BareKind::pillars) {
    aside = 0.2 * sizes.half_y;
  }
  hall.way[0] = weave(corners, draws.uniform(-aside, aside), draws);
  Way second = weave(corners, draws.uniform(-aside, aside), draws);
  if (against) std::reverse(second.begin(), second.end());
  const auto skipped =
      static_cast<std::ptrdiff_t>(draws.uniform(0.1, 0.5) * static_cast<double>(second.size()));
  second.erase(second.begin(), second.begin() + skipped);
  second.resize(std::min<std::size_t>(second.size(), 40));
  hall.way[1] = second;
}

ThingHall mirrored(ThingHall hall) {
  for (HallSolid& solid : hall.solids) {
    solid.foot.x = -solid.foot.x;
    solid.sine = -solid.sine;
  }
  for (Way& way : hall.way) {
    for (rt::Vector3& p : way) p.x = -p.x;
  }
  return hall;
}

}  // namespace

const char* name_of(BareKind kind) {
  constexpr const char* kNames[] = {"corridor",          "bend",           "hall",
                                    "hall with pillars", "winding tunnel", "plain corridor"};
  return kNames[static_cast<int>(kind)];
}

const char* name_of(BareTruth truth) {
  constexpr const char* kNames[] = {"same direction", "opposite", "another one", "mirrored", "two alike"};
  return kNames[static_cast<int>(truth)];
}

RecognitionWorld bare_world(BareKind kind, BareTruth truth, Draws& draws) {
  const BareSizes sizes = sizes_of(kind, draws);
  const bool against =
      truth == BareTruth::against || (truth != BareTruth::along && draws.uniform(0, 1) < 0.5);
  ThingHall hall = built(kind, sizes, draws);
  draw_ways(kind, sizes, against, hall, draws);
  RecognitionWorld world;
  world.is_kept = truth != BareTruth::another && truth != BareTruth::mirrored;
  // Not along the axes of the map.
  const HallAt first{hall, {{}, rt::from_yaw_pitch_roll(draws.uniform(-M_PI, M_PI), 0, 0)}};
  world.kept.push_back(first);
  world.now = first;
  if (truth == BareTruth::another) {
    world.now.hall = built(kind, sizes, draws);
    world.now.hall.way[0] = hall.way[0];
    world.now.hall.way[1] = hall.way[1];
  } else if (truth == BareTruth::mirrored) {
    world.now.hall = mirrored(hall);
  } else if (truth == BareTruth::twins) {
    const double yaw = draws.uniform(-M_PI, M_PI), away = 2.0 * (hall.half_x + hall.half_y) + 5.0;
    world.kept.push_back({hall, {{away, 0, 0}, rt::from_yaw_pitch_roll(yaw, 0, 0)}});
    if (draws.uniform(0, 1) < 0.5) world.now = world.kept.back();
  }
  return world;
}

}  // namespace sortie::bench
