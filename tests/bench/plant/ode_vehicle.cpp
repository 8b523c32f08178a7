// SPDX-License-Identifier: BSD-3-Clause
// The vehicle in ODE: one body with the outline of the reference simulator's model, 11 boxes and 12
// cylinders; flippers are held at their angles. Its tracks move as the reference's plug-in moves them, by
// friction directions and surface speeds set at each contact, with the speeds that fit one rigid motion.
#include "tests/bench/plant/bench_vehicle.hpp"

#if __has_include(<ode/ode.h>) && defined(SORTIE_PEER_ODE)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include <ode/ode.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cstdarg>

#include "tests/bench/plant/ode_geometry.hpp"

namespace sortie::bench {

namespace {

constexpr int kIterations = 20;
constexpr int kContactsOfPair = 8;
constexpr double kErp = 0.2;
constexpr double kCfm = 1e-6;
// What the reference simulator sets by default.
constexpr double kCorrectionSpeed_m_s = 100;
constexpr double kSurfaceLayer_m = 0.001;

std::uint64_t complaints = 0;

void count_complaint(int, const char*, va_list) { ++complaints; }

void start_ode() {
  static const bool started = [] {
    dInitODE2(0);
    dSetMessageHandler(count_complaint);
    return true;
  }();
  static_cast<void>(started);
}

class OdeVehicle : public BenchVehicle {
 public:
  OdeVehicle(const BenchScene& scene, OdeSolver solver) : solver_(solver) {
    start_ode();
    config_.friction = scene.friction;
    world_ = dWorldCreate();
    dWorldSetGravity(world_, 0, 0, -9.81);
    dWorldSetERP(world_, kErp);
    dWorldSetQuickStepNumIterations(world_, kIterations);
    dWorldSetContactMaxCorrectingVel(world_, kCorrectionSpeed_m_s);
    dWorldSetContactSurfaceLayer(world_, kSurfaceLayer_m);
    dRandSetSeed(1);
    hil::PlantScene obstacles;
    scene.build(obstacles);
    obstacles_ = add_ode_obstacles(obstacles);
    vehicle_ = add_ode_vehicle(world_, config_, scene);
    joints_ = dJointGroupCreate(0);
  }
  ~OdeVehicle() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(vehicle_.space);
    dSpaceDestroy(obstacles_);
    dWorldDestroy(world_);
  }
  OdeVehicle(const OdeVehicle&) = delete;
  OdeVehicle& operator=(const OdeVehicle&) = delete;

  void step(const BeltSpeeds& belts, double dt_s) override {
    belts_ = hil::belt_motion(belts.left_m_s, belts.right_m_s, dt_s, config_);
    pose_ = pose();
    turn_ = hil::to_matrix(pose_.q_world_body);
    dSpaceCollide2(reinterpret_cast<dGeomID>(vehicle_.space), reinterpret_cast<dGeomID>(obstacles_), this,
                   near_pair);
    if (solver_ == OdeSolver::quick)
      dWorldQuickStep(world_, dt_s);
    else
      dWorldStep(world_, dt_s);
    dJointGroupEmpty(joints_);
  }

  BenchPose pose() const override {
    const dReal* p = dBodyGetPosition(vehicle_.body);
    const dReal* q = dBodyGetQuaternion(vehicle_.body);
    const hil::Quat turn{q[0], q[1], q[2], q[3]};
    return {hil::Vec3{p[0], p[1], p[2]} - hil::rotate(turn, vehicle_.com_m), turn};
  }

  double deepest_m() const override { return deepest_m_; }

 private:
  static void near_pair(void* self, dGeomID first, dGeomID second) {
    static_cast<OdeVehicle*>(self)->collide(first, second);
  }

  void collide(dGeomID first, dGeomID second) {
    // Of either order; the vehicle's geometry comes first, so that normals point into it.
    if (dGeomGetBody(first) == nullptr) std::swap(first, second);
    dContact contacts[kContactsOfPair];
    const int count = dCollide(first, second, kContactsOfPair, &contacts[0].geom, sizeof(dContact));
    const auto side = static_cast<int>(reinterpret_cast<std::intptr_t>(dGeomGetData(first)));
    for (int i = 0; i < count; ++i) {
      dContact& contact = contacts[i];
      deepest_m_ = std::max(deepest_m_, contact.geom.depth);
      set_surface(side, contact);
      dJointAttach(dJointCreateContact(world_, joints_, &contact), vehicle_.body, nullptr);
    }
  }

  void set_surface(int side, dContact& contact) const {
    const dReal* p = contact.geom.pos;
    const dReal* n = contact.geom.normal;
    const hil::Vec3 point = hil::back(turn_, hil::Vec3{p[0], p[1], p[2]} - pose_.p_world_m);
    const hil::Vec3 normal = hil::back(turn_, hil::Vec3{n[0], n[1], n[2]});
    hil::Vec3 target;
    if (side != 0) target = hil::surface_target(point, normal, side, belts_, config_);
    const double speed = hil::norm(target);
    hil::Vec3 along = speed > 1e-9 ? target : hil::Vec3{normal.z, 0, -normal.x};
    if (hil::norm(along) < 1e-9) along = {1, 0, 0};
    const hil::Vec3 direction = turn_ * ((1.0 / hil::norm(along)) * along);
    contact.fdir1[0] = direction.x;
    contact.fdir1[1] = direction.y;
    contact.fdir1[2] = direction.z;
    dSurfaceParameters& surface = contact.surface;
    surface = {};
    surface.mode =
        dContactMu2 | dContactFDir1 | dContactMotion1 | dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    surface.mu = side != 0 ? config_.friction : config_.body_friction;
    surface.mu2 = surface.mu;
    surface.motion1 = speed;
    surface.soft_erp = kErp;
    surface.soft_cfm = kCfm;
  }

  OdeSolver solver_;
  hil::VehicleConfig config_;
  dWorldID world_{};
  dSpaceID obstacles_{};
  OdeBody vehicle_;
  dJointGroupID joints_{};
  hil::BeltMotion belts_;
  BenchPose pose_;
  hil::Matrix3 turn_;
  double deepest_m_{};
};

}  // namespace

bool has_ode() { return true; }

std::uint64_t ode_complaints() { return complaints; }

std::unique_ptr<BenchVehicle> make_ode_vehicle(const BenchScene& scene, OdeSolver solver) {
  return std::make_unique<OdeVehicle>(scene, solver);
}

}  // namespace sortie::bench

#else

namespace sortie::bench {

bool has_ode() { return false; }

std::uint64_t ode_complaints() { return 0; }

std::unique_ptr<BenchVehicle> make_ode_vehicle(const BenchScene&, OdeSolver) { return nullptr; }

}  // namespace sortie::bench

#endif
