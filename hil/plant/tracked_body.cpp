// SPDX-License-Identifier: BSD-3-Clause
#include "hil/plant/tracked_body.hpp"

#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

rt::Nanoseconds checked(rt::Nanoseconds step_ns) {
  const double step_s = rt::to_seconds(step_ns);
  require("plant", step_s >= TrackedPlant::kShortestStep_s && step_s <= TrackedPlant::kLongestStep_s,
          "the step must lie in 0.1 to 20 ms");
  return step_ns;
}

}  // namespace

TrackedBody::TrackedBody(const TrackedBodyConfig& config, const PlantScene& scene, rt::Nanoseconds start_ns,
                         rt::Nanoseconds step_ns)
    : step_ns_(checked(step_ns)),
      height_m_(config.height_m),
      drives_(config.drives, step_ns, "plant"),
      plant_(config.plant, scene),
      gravity_m_s2_(config.plant.gravity_m_s2) {
  require("plant", std::isfinite(config.height_m), "height_m must be finite");
  for (int i = 0; i < kFlippers; ++i) command_.flipper_rad[i] = config.plant.start_flipper_rad[i];
  motion_.stamp_ns = start_ns;
  update_motion();
}

Status TrackedBody::set_flippers(const drivers::FlipperPairCommand& command) {
  if (!std::isfinite(command.left_rad) || !std::isfinite(command.right_rad)) return Status::not_finite;
  const int left = command.pair == drivers::FlipperPair::front ? 0 : 2;
  const bool enabled = (command.flags & 1u) != 0;
  const double* now = plant_.state().flipper_set_rad;
  command_.flipper_rad[left] = enabled ? command.left_rad : now[left];
  command_.flipper_rad[left + 1] = enabled ? command.right_rad : now[left + 1];
  return Status::ok;
}

void TrackedBody::step() {
  motion_.stamp_ns += step_ns_;
  const Vec3 gravity_body = rotate(conjugate(motion_.q_world_body), Vec3{0, 0, -gravity_m_s2_});
  drives_.advance(motion_.stamp_ns, gravity_body.x);
  command_.left_m_s = drives_.left().speed_m_s();
  command_.right_m_s = drives_.right().speed_m_s();
  // Commands were checked when they came, the step at the start; what does not stay finite is counted.
  static_cast<void>(plant_.step(command_, rt::to_seconds(step_ns_)));
  update_motion();
}

void TrackedBody::update_motion() {
  const rt::Nanoseconds stamp_ns = motion_.stamp_ns;
  motion_ = plant_.motion(stamp_ns);
  const Vec3 down{0, 0, -height_m_};
  motion_.p_world_body_m = motion_.p_world_body_m + rotate(motion_.q_world_body, down);
  motion_.v_world_m_s = motion_.v_world_m_s + rotate(motion_.q_world_body, cross(motion_.w_body_rad_s, down));
}

bool TrackedBody::read_flippers(rt::FlipperSample& sample) const {
  sample = {};
  sample.stamp_ns = motion_.stamp_ns;
  for (int i = 0; i < kFlippers; ++i) {
    sample.angle_rad[i] = plant_.state().flipper_rad[i];
    sample.torque_n_m[i] = plant_.flipper_torque_nm(i);
  }
  return true;
}

bool TrackedBody::read_contacts(rt::ContactTruth& truth) const {
  truth = {};
  truth.stamp_ns = motion_.stamp_ns;
  truth.step_ns = step_ns_;
  for (int i = 0; i < kFlippers; ++i) {
    truth.flipper_asked_rad[i] = command_.flipper_rad[i];
    truth.flipper_angle_rad[i] = plant_.state().flipper_rad[i];
    truth.flipper_torque_n_m[i] = plant_.flipper_torque_nm(i);
  }
  const ContactList& contacts = plant_.contacts();
  for (std::uint32_t i = 0; i < contacts.size() && i < plant_.tags().size(); ++i) {
    const ContactPoint& found = contacts[i];
    const ContactTag& tag = plant_.tags()[i];
    if (found.grip == Grip::open && tag.gap_m > 0.0) continue;  // listed because it might have touched
    rt::TruthContact contact;
    contact.part = static_cast<rt::VehiclePart>(tag.part);
    const double load = dot(found.impulse_ns, found.normal);
    store(found.point_m + Vec3{0, 0, height_m_}, contact.point_m);
    store(found.normal, contact.normal);
    contact.normal_impulse_n_s = load;
    store(found.impulse_ns - load * found.normal, contact.friction_impulse_n_s);
    contact.penetration_m = -tag.gap_m;
    if (!truth.contacts.push_back(contact)) ++truth.dropped;
  }
  return true;
}

}  // namespace sortie::hil
