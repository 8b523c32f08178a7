// SPDX-License-Identifier: BSD-3-Clause
// Contacts with solids, and the bookkeeping of all contacts.
#include "hil/plant/contact_finder.hpp"

#include <algorithm>
#include <cmath>

#include "rt/convex/manifold.hpp"
#include "rt/convex/support.hpp"

namespace sortie::hil {
namespace {

constexpr double kScanRoom_m = 0.3;  ///< how far the vehicle may go before the whole scene is looked at again

Vec3 from(const rt::Vector3& v) { return {v.x, v.y, v.z}; }
rt::Vector3 to(const Vec3& v) { return {v.x, v.y, v.z}; }

/// A shape given in body axes, in the world.
void to_world(const BodyPose& pose, rt::convex::Convex& shape) {
  shape.p_world_m = to(pose.p_world_m + pose.R_world_body * from(shape.p_world_m));
  Matrix3 local;
  for (int i = 0; i < 9; ++i) local.m[i / 3][i % 3] = shape.R_world_body.m[i];
  const Matrix3 world = pose.R_world_body * local;
  for (int i = 0; i < 9; ++i) shape.R_world_body.m[i] = world.m[i / 3][i % 3];
}

rt::convex::Bounds widened(rt::convex::Bounds b, double margin_m) {
  b.low_m = b.low_m - rt::Vector3{margin_m, margin_m, margin_m};
  b.high_m = b.high_m + rt::Vector3{margin_m, margin_m, margin_m};
  return b;
}

}  // namespace

ContactFinder::ContactFinder(const VehicleModel& model, const PlantScene& scene)
    : model_(&model), scene_(&scene) {
  const VehicleConfig& c = model.config();
  const double flipper = norm(c.flipper_pivot_m) + c.flipper_length_m +
                         std::max(c.flipper_large_radius_m, c.flipper_small_radius_m) + c.flipper_width_m;
  const double track = norm(c.track_centre_m) + c.track_half_length_m + c.track_radius_m + c.track_width_m;
  const double body = norm(c.body_centre_m) + norm(c.body_half_m);
  reach_m_ = std::max({flipper, track, body});
}

void ContactFinder::find(const BodyPose& pose, const MassState& state, const BeltMotion& belts,
                         double margin_m, double dt_s, ContactProblem& problem) {
  contacts_ = &problem.contacts;
  belts_ = &belts;
  margin_m_ = margin_m;
  dt_s_ = dt_s;
  cursor_ = 0;
  problem.contacts.clear();
  tags_.clear();
  for (std::uint32_t i = 0; i < scene_->half_spaces().size(); ++i) {
    half_space_contacts(pose, state, static_cast<int>(i));
  }
  if (!scene_->solids().empty()) solid_contacts(pose, state);
}

void ContactFinder::rescan(const Vec3& p) {
  const double away = std::max({std::fabs(p.x - scan_centre_m_.x), std::fabs(p.y - scan_centre_m_.y),
                                std::fabs(p.z - scan_centre_m_.z)});
  if (scanned_ && away + margin_m_ <= kScanRoom_m) return;
  scanned_ = true;
  scan_centre_m_ = p;
  near_count_ = 0;
  const double reach = reach_m_ + kScanRoom_m + margin_m_;
  const rt::convex::Bounds around = widened({to(p), to(p)}, reach);
  for (std::uint32_t i = 0; i < scene_->solids().size(); ++i) {
    if (!rt::convex::overlap(around, scene_->solids()[i].bounds)) continue;
    near_[near_count_++] = static_cast<std::uint16_t>(i);
  }
}

void ContactFinder::solid_contacts(const BodyPose& pose, const MassState& state) {
  rescan(pose.p_world_m);
  if (near_count_ == 0) return;
  rt::convex::ManifoldOptions options;
  options.margin_m = margin_m_;
  for (int part = 0; part < kParts; ++part) {
    rt::convex::Convex shape = model_->shape(part, state);
    to_world(pose, shape);
    const rt::convex::Bounds bounds = widened(rt::convex::bounds(shape), margin_m_);
    for (std::uint32_t k = 0; k < near_count_; ++k) {
      const PlantScene::Solid& solid = scene_->solids()[near_[k]];
      if (!rt::convex::overlap(bounds, solid.bounds)) continue;
      const rt::convex::Manifold found = rt::convex::manifold(shape, solid.shape, options);
      for (std::uint32_t i = 0; i < found.count; ++i) {
        const rt::convex::Contact& contact = found.contacts[i];
        add(part, near_[k], contact.id, back(pose.R_world_body, from(contact.point_m) - pose.p_world_m),
            back(pose.R_world_body, from(contact.normal)), -contact.depth_m);
      }
    }
  }
}

void ContactFinder::add(int part, int object, std::uint32_t feature, const Vec3& point_m, const Vec3& normal,
                        double gap_m) {
  const VehicleConfig& config = model_->config();
  ContactPoint contact;
  contact.point_m = point_m;
  contact.normal = normal;
  contact.approach_m_s = std::max(0.0, gap_m) / dt_s_;
  contact.friction = part == 0 ? config.body_friction : config.friction;
  if (part > 0) contact.target_m_s = surface_target(point_m, normal, side_of(part), *belts_, config);
  contact.joint = std::max(-1, joint_of(part));
  if (contact.joint >= 0) {
    const Vec3 r = point_m - model_->pivot(contact.joint);
    contact.lever_m = VehicleModel::axis_sign(contact.joint) * Vec3{r.z, 0.0, -r.x};
  }
  const std::uint64_t key = (static_cast<std::uint64_t>(part) << 48u) |
                            (static_cast<std::uint64_t>(static_cast<std::uint16_t>(object)) << 32u) | feature;
  warm(contact, key);
  // What does not fit is left out.
  if (contacts_->push_back(contact))
    static_cast<void>(
        tags_.push_back({key, gap_m, static_cast<std::int16_t>(object), static_cast<std::uint8_t>(part)}));
}

void ContactFinder::warm(ContactPoint& contact, std::uint64_t key) {
  for (std::uint32_t i = 0; i < memory_count_; ++i) {
    const std::uint32_t at = cursor_ + i < memory_count_ ? cursor_ + i : cursor_ + i - memory_count_;
    if (memory_[at].key != key) continue;
    cursor_ = at + 1;
    contact.impulse_ns = memory_[at].impulse_ns;
    return;
  }
}

void ContactFinder::remember(const ContactProblem& problem) {
  memory_count_ = problem.contacts.size();
  for (std::uint32_t i = 0; i < memory_count_; ++i) {
    const ContactPoint& c = problem.contacts[i];
    memory_[i] = {tags_[i].key, c.impulse_ns};
  }
}

}  // namespace sortie::hil
