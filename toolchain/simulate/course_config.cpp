// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/hil_config.hpp"

#include <algorithm>
#include <iterator>

#include "firmware_like/scene/units.hpp"

namespace sortie::toolchain {

namespace {

constexpr std::size_t kMostPieces = 64;

// In the order of hil::CourseKind.
const char* const kKinds[] = {"stairs", "pallet", "ramp", "rubble", "cylinder", "wall"};

hil::CourseKind kind_of(const firmware::Profile& profile, const firmware::ProfileRow& row) {
  const std::string& name = row.texts.at("kind");
  const auto found = std::find(std::begin(kKinds), std::end(kKinds), name);
  if (found == std::end(kKinds))
    profile.fail(row.path + ".kind",
                 "no obstacle \"" + name + "\"; known: stairs, pallet, ramp, rubble, cylinder, wall");
  return static_cast<hil::CourseKind>(found - std::begin(kKinds));
}

std::vector<hil::CoursePiece> read_pieces(firmware::Profile& profile) {
  using Kind = firmware::ColumnSpec::Kind;
  const hil::CoursePiece usual;
  const std::vector<firmware::ColumnSpec> columns = {
      {"kind", Kind::text, {}, true},
      {"x_m", Kind::number, {0, -1e3, 1e3, "m"}, true},
      {"y_m", Kind::number, {0, -1e3, 1e3, "m"}},
      {"yaw_deg", Kind::number, {0, -360, 360, "deg"}},
      {"length_m", Kind::number, {usual.length_m, 0.01, 100, "m"}},
      {"width_m", Kind::number, {usual.width_m, 0.01, 100, "m"}},
      {"height_m", Kind::number, {usual.height_m, 0.01, 10, "m"}},
      {"slope_deg", Kind::number, {usual.slope_rad / firmware::kDegree, 0, 60, "deg"}},
      {"deck_m", Kind::number, {usual.deck_m, 0, 100, "m"}},
      {"run_m", Kind::number, {usual.run_m, 0.05, 2, "m"}},
      {"count", Kind::number, {static_cast<double>(usual.count), 1, 200}},
  };
  std::vector<hil::CoursePiece> pieces;
  for (const firmware::ProfileRow& row :
       profile.rows("hil.course", columns, kMostPieces,
                    "with contacts: obstacles, met at (x, y) along their heading")) {
    hil::CoursePiece& piece = pieces.emplace_back();
    piece.kind = kind_of(profile, row);
    piece.x_m = row.numbers.at("x_m");
    piece.y_m = row.numbers.at("y_m");
    piece.yaw_rad = row.numbers.at("yaw_deg") * firmware::kDegree;
    piece.length_m = row.numbers.at("length_m");
    piece.width_m = row.numbers.at("width_m");
    piece.height_m = row.numbers.at("height_m");
    piece.slope_rad = row.numbers.at("slope_deg") * firmware::kDegree;
    piece.deck_m = row.numbers.at("deck_m");
    piece.run_m = row.numbers.at("run_m");
    piece.count = static_cast<std::uint32_t>(row.numbers.at("count"));
    if (static_cast<double>(piece.count) != row.numbers.at("count"))
      profile.fail(row.path + ".count", "must be a whole number");
  }
  return pieces;
}

}  // namespace

void read_course(firmware::Profile& profile, hil::UgvConfig& config) {
  config.contacts =
      profile.flag("hil.contacts", false,
                   "the robot has masses and contacts and drives on [[hil.course]], not in the hall");
  config.course.pieces = read_pieces(profile);
  config.course.seed =
      static_cast<std::uint64_t>(profile.integer("hil.course_seed", {1, 0, 1e15, "", "of the rubble"}));
  hil::VehicleConfig& vehicle = config.tracked.plant.vehicle;
  read_number(profile, "hil.friction", vehicle.friction, 0, 10, "", "of belts and flippers on everything");
  read_number(profile, "hil.mass_scale", vehicle.mass_scale, 0.01, 1000, "", "of all masses");
  const std::string mode =
      profile.text("hil.contact_mode", "belt",
                   "how a belt's surface moves: about a turning centre, or along the belt", {"csm", "belt"});
  vehicle.mode = mode == "csm" ? hil::ContactMode::csm : hil::ContactMode::belt;
  const double front = profile.number("hil.front_flippers_deg", {28, -180, 180, "deg", "at the start"});
  const double rear = profile.number("hil.rear_flippers_deg", {28, -180, 180, "deg", "at the start"});
  for (int i = 0; i < hil::kFlippers; ++i)
    config.tracked.plant.start_flipper_rad[i] = (i < 2 ? front : rear) * firmware::kDegree;
  config.tracked.plant.start_m = {config.robot.start_x_m, config.robot.start_y_m, config.tracked.height_m};
  config.tracked.plant.start_q_world_body = hil::from_yaw_pitch_roll(config.robot.start_yaw_rad, 0, 0);
  config.tracked.drives = config.robot.drives;
  if (!config.contacts && !config.course.pieces.empty())
    profile.fail("hil.course", "has no effect without hil.contacts = true");
}

}  // namespace sortie::toolchain
