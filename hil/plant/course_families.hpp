// SPDX-License-Identifier: BSD-3-Clause
// Courses drawn by seed for the tracked vehicle: thirteen families of terrain, for tuning and for judging.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "hil/plant/plant_scene.hpp"
#include "hil/plant/tracked_plant.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::hil {

/// What lies between start and goal.
enum class TerrainFamily : std::uint8_t {
  step_up,
  step_down,
  uplift,       ///< a box across the way: on and off again
  single_step,  ///< a box under one track
  posts,        ///< plum piles: posts of different heights between two platforms
  waves,        ///< a cosine along the way, in facets
  rails,        ///< one bar at an angle to the way
  stairs_up,
  stairs_down,
  pallets,
  ramp,
  rubble,
  gap,
};
inline constexpr int kTerrainFamilies = 13;

/// Name of a family, as tables print it.
const char* name_of(TerrainFamily family);

/// Who may look at a course. Judging has its own stream of seeds and its own way of drawing: sizes gather
/// about the difficulty in another distribution, edges are not square to the way, the start is off the line,
/// stairs are uneven, posts are not in rows, rails may be round, rubble is of slabs.
enum class CourseUse : std::uint8_t { tuning, judging };

/// A size of a family, and between which values it is drawn, both ends included. SI units, as the name says.
struct CourseRange {
  const char* name;
  double low, high;
  int harder;  ///< +1: grows with the difficulty; -1: shrinks; 0: drawn without regard to it
};

/// The sizes that all courses have: friction and load. Static storage.
std::span<const CourseRange> common_ranges();
/// The sizes of a family beside those.
std::span<const CourseRange> ranges_of(TerrainFamily family);

/// A drawn size.
struct CourseParameter {
  const char* name{};
  double value{};
};
inline constexpr std::uint32_t kMaxCourseParameters = 8;

/// A course. The world's axes: the way leads along x, z is up, the lowest ground is z = 0. Copies share the
/// solids, which nobody changes.
struct Course {
  TerrainFamily family{};
  CourseUse use{};
  std::uint64_t seed{};
  double difficulty{};
  rt::FixedVector<CourseParameter, kMaxCourseParameters> parameters;
  Vec3 start_m;  ///< of the body's origin, on level ground
  double start_yaw_rad{};
  double goal_x_m{}, goal_y_m{};
  double half_width_m{};  ///< the terrain is the same that far to either side of the way
  double obstacle_m{};    ///< x of the first edge; what touches ground beyond has touched the obstacle
  std::shared_ptr<const PlantScene> scene;

  /// A drawn size by its name; throws std::runtime_error where the family has none of that name.
  double parameter(std::string_view name) const;
  /// The upper surface at a place, m: closed form over the solids. Cost: 5 to 50 ns.
  double height(double x_m, double y_m) const;
};

/// Draws a course. Equal arguments give equal courses to the last bit on all boards. `difficulty` in 0..1
/// leads the sizes through their ranges. Throws std::runtime_error for a difficulty outside, or a family that
/// is none. Allocates the solids, 80 kB.
Course draw_course(CourseUse use, TerrainFamily family, std::uint64_t seed, double difficulty);

/// The course as a mirror along the way shows it: left and right changed.
Course mirrored(const Course& course);

/// The plant at the start of a course, with its friction and load; flippers as the default has them.
PlantConfig plant_config(const Course& course);

/// One number for all of a course: equal courses have equal ones.
std::uint64_t digest_of_course(const Course& course);

}  // namespace sortie::hil
