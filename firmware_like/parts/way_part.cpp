// SPDX-License-Identifier: BSD-3-Clause
// Ways to a goal over ground that was seen to carry. The drive follows them.
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "planner/ground_way/ground_way_follower.hpp"
#include "planner/ground_way/ground_way_planner.hpp"
#include "planner/ugv_drive.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {
namespace {

/// The window of the way's lattice, and what of the robot it needs to know.
struct WayLattice {
  std::int32_t cells{128};
  std::int32_t cell_mm{100};
  double half_length_m{0.45};
  double half_width_m{0.3};

  SORTIE_KEYS(c, key) {
    key("cells", c.cells, {32, 512, "", "of the window along x and y"});
    key("cell_mm", c.cell_mm, {20, 1000, "mm", "edge of a cell, a multiple of elevation.cell_mm"});
    key("half_length_m", c.half_length_m,
        {0.05, 3, "m", "of the robot and its flippers, as they stand while it drives, from its middle"});
    key("half_width_m", c.half_width_m, {0.05, 3, "m", "of the robot, from its middle"});
  }
};

/// Group `mapping`, task `way`, behind `elevation`.
class WayPart final : public Part {
 public:
  explicit WayPart(VehicleBuilder& builder) {
    Profile& profile = builder.profile();
    const rt::GroupId group = builder.group("mapping", 10);
    const ElevationAccess* elevation = builder.find<ElevationAccess>();
    located_ = builder.find<LocateAccess>();
    const auto* drive = builder.find<rt::Task<planner::UgvDriveOutput>>();
    if (drive == nullptr)
      profile.fail("tasks.way.enabled", "ways are for somebody who drives: needs tasks.drive");
    map_ = elevation->map;
    drive_ = builder.input(group, drive, 1);
    poses_ = poses_since_last_job(builder, group);
    WayLattice lattice;
    profile.read("way", lattice);
    planner::GroundWayConfig config;
    profile.read("way", config);
    profile.read("way", config.rules);
    config.lattice.nx = config.lattice.ny = lattice.cells;
    config.lattice.cell_mm = lattice.cell_mm;
    // The drive may be beside its way by as much before it stops.
    planner::GroundWayFollowerConfig follower;
    profile.read("way", follower);
    // A way begins in the middle of the cell where the robot stands.
    if (follower.off_m < 0.75e-3 * lattice.cell_mm)
      profile.fail("way.off_m", "must not be below three quarters of way.cell_mm");
    const auto mm_of = [&follower](double half_m) {
      return static_cast<std::int32_t>(1e3 * (half_m + follower.off_m) + 0.5);
    };
    config.lattice.half_length_mm = mm_of(lattice.half_length_m);
    config.lattice.half_width_mm = mm_of(lattice.half_width_m);
    // What lies farther above or below the robot's middle than its tilt and a step allow is another floor.
    const double half_m = 1e-3 * (config.lattice.half_length_mm + config.lattice.half_width_mm);
    config.lattice.reach_mm = static_cast<std::int32_t>(
        1e3 * (config.rules.most_step_m + half_m * rt::tan(config.rules.most_tilt_rad)));
    config.lattice.unknown = planner::UnknownGround::by_price;
    if (lattice.cell_mm % map_->config().cell_mm != 0)
      profile.fail("way.cell_mm", "must be a multiple of elevation.cell_mm");
    if (planner::check(config.lattice) != Status::ok)
      profile.fail("way.half_length_m",
                   "must not be below way.half_width_m, nor above 12 cells of the lattice");
    planner_ = std::make_unique<planner::GroundWayPlanner>(config, map_->config().cell_mm, builder.arena());
    if (!planner_->usable() && builder.arena().refused() == 0)
      profile.fail("way.cells", "the window is too small for a robot of this size");
    task_ = builder.task<planner::GroundWay>(
        group, "way", TaskDefaults{15'000, rt::Criticality::b, 40'000},
        [this](rt::JobContext& context, planner::GroundWay& output) {
          begin(context.release_ns);
          while (planner_->works() && context.spend(planner::GroundWayPlanner::kSlice)) planner_->step();
          planner_->end();
          output = planner_->output();
          to_odometry(output);
        });
    builder.remembers(task_, *this);
    builder.offer(*task_);
    const planner::GroundWay& way = planner_->output();
    builder.counter("way_plans", [&way] { return way.plans; });
    builder.counter("way_replanned", [&way] { return way.replanned; });
    builder.counter("way_refused", [&way] { return way.refused; });
    builder.counter("way_lost", [&way] { return way.lost; });
    builder.counter("way_bad_poses", [this] { return bad_; });
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "way")
        .base<Part>()
        .fixed(map_, located_, drive_, poses_, task_)
        .by_hand(planner_)
        .state(bad_, T_map_odom_);
    archive.value(*planner_);
  }

 private:
  void begin(rt::Nanoseconds now_ns) {
    const planner::UgvDriveOutput* drive = drive_->latest();
    const rt::PoseEstimate* pose = poses_->latest();
    planner::GroundWayProgress progress;
    bool standing = true;
    if (drive != nullptr) {
      progress = {
          drive->goal, {drive->goal_x_m, drive->goal_y_m},         drive->way_series, drive->way_step, false,
          false,       (drive->flags & planner::kDriveOffWay) != 0};
      const bool to_goal = drive->source == static_cast<std::uint32_t>(planner::DriveSource::goal);
      progress.in_control = to_goal;
      progress.arrived = to_goal && (drive->flags & planner::kDriveDone) != 0;
      standing = drive->speed_m_s == 0.0 && drive->turn_rad_s == 0.0;
    }
    rt::PoseEstimate on_map = pose != nullptr ? *pose : rt::PoseEstimate{};
    if (located_ != nullptr) {
      // Where it has no place it is where it would be with the last one.
      const mapping::Located& located = located_->locator->located();
      if (mapping::is_placed(located.verdict)) T_map_odom_ = located.T_map_odom;
      const mapping::RigidPose body = mapping::after(
          T_map_odom_, {rt::to_vector(on_map.p_world_body_m), rt::to_quaternion(on_map.q_world_body)});
      rt::store(body.p, on_map.p_world_body_m);
      rt::store(body.q, on_map.q_world_body);
    }
    const Status status =
        planner_->begin(map_->view(), on_map, standing, progress, map_->output().stamp_ns, now_ns);
    bad_ += status == Status::not_finite ? 1u : 0u;
  }

  /// The drive goes by the odometry: each job tells it anew where the same places are for it.
  void to_odometry(planner::GroundWay& way) const {
    if (located_ == nullptr) return;
    const mapping::RigidPose T_odom_map = mapping::inverse(T_map_odom_);
    const double turn = rt::yaw_of(T_odom_map.q);
    for (std::uint32_t i = 0; i < way.steps; ++i) {
      const rt::Vector3 p_m =
          mapping::after(T_odom_map, {{1e-3 * way.x_mm[i], 1e-3 * way.y_mm[i], 0.0}, {}}).p;
      const double heading = rt::wrap_angle(1e-3 * way.heading_mrad[i] + turn);
      way.x_mm[i] = static_cast<std::int32_t>(rt::floor(1e3 * p_m.x + 0.5));
      way.y_mm[i] = static_cast<std::int32_t>(rt::floor(1e3 * p_m.y + 0.5));
      way.heading_mrad[i] = static_cast<std::int16_t>(rt::floor(1e3 * heading + 0.5));
    }
  }

  const mapping::ElevationMap* map_{};
  const LocateAccess* located_{};  // null: the odometry's frame is the world's
  mapping::RigidPose T_map_odom_;
  rt::Input<planner::UgvDriveOutput>* drive_{};
  rt::Input<rt::PoseEstimate>* poses_{};
  std::unique_ptr<planner::GroundWayPlanner> planner_;
  rt::Task<planner::GroundWay>* task_{};
  std::uint64_t bad_{};
};

}  // namespace

std::unique_ptr<Part> make_way(VehicleBuilder& builder) { return std::make_unique<WayPart>(builder); }

}  // namespace sortie::firmware
