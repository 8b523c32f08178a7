// SPDX-License-Identifier: BSD-3-Clause
// Random furniture of the hall: a seed decides what stands where; the robot's way stays free.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/hall.hpp"
#include "hil/random.hpp"

namespace sortie::hil {
namespace {

constexpr int kTriesPerPiece = 20;
constexpr double kGap_m = 0.15;  // between two pieces, so that the lidar sees an edge between them
constexpr std::size_t kMaxParts = 5;

/// A piece before it has a place: its parts relative to its own centre.
struct Piece {
  BoxShape parts[kMaxParts];
  std::size_t count{};
  bool round{};
  double half_x_m{};  ///< half the outline that must be free
  double half_y_m{};
  double top_m{};
  std::uint16_t reflectivity{};
};

Piece crate(Random& random) {
  const double side = random.uniform(0.4, 0.9);
  const double aspect = random.uniform(0.6, 1.0);
  const double height = random.uniform(0.3, 1.0);
  const double upper = random.uniform();
  Piece piece{
      {{0, 0, 0, side, side * aspect, 0, height}}, 1, false, 0.5 * side, 0.5 * side * aspect, height, 110};
  if (upper < 0.4) {  // a second, smaller crate on top
    piece.parts[1] = {0, 0, 0, 0.7 * side, 0.7 * side * aspect, height, height + 0.6 * height};
    piece.count = 2;
    piece.top_m = 1.6 * height;
  }
  return piece;
}

Piece barrel(Random& random) {
  const double radius = random.uniform(0.2, 0.35);
  const double height = random.uniform(0.6, 1.1);
  return {{{0, 0, 0, 2 * radius, 2 * radius, 0, height}}, 1, true, radius, radius, height, 200};
}

Piece shelf(Random& random) {
  const double length = random.uniform(1.0, 2.2);
  const double height = random.uniform(1.4, 2.2);
  return {{{0, 0, 0, length, 0.4, 0, height}}, 1, false, 0.5 * length, 0.2, height, 130};
}

Piece table(Random& random) {
  const double length = random.uniform(1.0, 1.8);
  const double width = random.uniform(0.6, 0.9);
  constexpr double kTop_m = 0.75;
  constexpr double kLeg_m = 0.06;
  Piece piece;
  piece.parts[0] = {0, 0, 0, length, width, kTop_m - 0.04, kTop_m};
  const double x = 0.5 * (length - kLeg_m);
  const double y = 0.5 * (width - kLeg_m);
  const double corners[4][2] = {{x, y}, {x, -y}, {-x, y}, {-x, -y}};
  for (std::size_t i = 0; i < 4; ++i) {
    piece.parts[i + 1] = {corners[i][0], corners[i][1], 0, kLeg_m, kLeg_m, 0, kTop_m - 0.04};
  }
  piece.count = 5;
  piece.half_x_m = 0.5 * length;
  piece.half_y_m = 0.5 * width;
  piece.top_m = kTop_m;
  piece.reflectivity = 160;
  return piece;
}

Piece draw_piece(Random& random) {
  const double kind = random.uniform();
  if (kind < 0.45) return crate(random);
  if (kind < 0.65) return barrel(random);
  if (kind < 0.85) return shelf(random);
  return table(random);
}

bool is_free(const HallConfig& config, const World& world, const Piece& piece, const Footprint& place) {
  const double reach = std::sqrt(piece.half_x_m * piece.half_x_m + piece.half_y_m * piece.half_y_m);
  const double margin = config.path_clearance_m + reach;
  if (distance_to_path(config, place.center_x_m, place.center_y_m) < margin) return false;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (overlaps(place, world.solid(i))) return false;
  }
  return true;
}

void place_piece(World& world, const Piece& piece, const Footprint& place, double yaw_rad) {
  for (std::size_t i = 0; i < piece.count; ++i) {
    BoxShape shape = piece.parts[i];
    const double x = shape.center_x_m;
    const double y = shape.center_y_m;
    shape.center_x_m = place.center_x_m + place.cos_yaw * x - place.sin_yaw * y;
    shape.center_y_m = place.center_y_m + place.sin_yaw * x + place.cos_yaw * y;
    shape.yaw_rad = yaw_rad;
    const Solid solid = piece.round ? make_cylinder(shape.center_x_m, shape.center_y_m, 0.5 * shape.length_m,
                                                    shape.bottom_m, shape.top_m, piece.reflectivity)
                                    : make_box(shape, piece.reflectivity);
    static_cast<void>(world.add(solid));  // room and extents were checked before
  }
}

}  // namespace

double distance_to_path(const HallConfig& config, double x_m, double y_m) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < config.path_points; ++i) {
    const PlanPoint& a = config.path_m[i];
    const PlanPoint& b = config.path_m[i + 1 < config.path_points ? i + 1 : i];
    const double dx = b.x_m - a.x_m;
    const double dy = b.y_m - a.y_m;
    const double length2 = dx * dx + dy * dy;
    const double along = length2 > 0.0 ? ((x_m - a.x_m) * dx + (y_m - a.y_m) * dy) / length2 : 0.0;
    const double share = std::clamp(along, 0.0, 1.0);
    const double ex = a.x_m + share * dx - x_m;
    const double ey = a.y_m + share * dy - y_m;
    nearest = std::min(nearest, std::sqrt(ex * ex + ey * ey));
  }
  return nearest;
}

HallReport add_furniture(const HallConfig& config, World& world) {
  HallReport report;
  report.seed = config.seed;
  Random random(config.seed, 0x68616c6c);
  for (std::uint32_t n = 0; n < config.furniture; ++n) {
    const Piece piece = draw_piece(random);
    bool placed = world.size() + piece.count > World::kMaxSolids;
    for (int attempt = 0; attempt < kTriesPerPiece && !placed; ++attempt) {
      Footprint place;
      place.center_x_m = config.west_x_m + config.length_m * random.uniform();
      place.center_y_m = config.width_m * (random.uniform() - 0.5);
      const double yaw = random.uniform(-3.14159265358979323846, 3.14159265358979323846);
      place.cos_yaw = rt::cos(yaw);
      place.sin_yaw = rt::sin(yaw);
      place.half_x_m = piece.half_x_m + kGap_m;
      place.half_y_m = piece.half_y_m + kGap_m;
      place.top_m = piece.top_m;
      if (!is_free(config, world, piece, place)) continue;
      place_piece(world, piece, place, yaw);
      ++report.furniture_placed;
      placed = true;
    }
  }
  report.furniture_left_out = config.furniture - report.furniture_placed;
  return report;
}

}  // namespace sortie::hil
