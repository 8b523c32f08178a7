// SPDX-License-Identifier: BSD-3-Clause
// Where the vehicle touches the scene, or will within the step, and what each contact did a step ago.
#pragma once

#include <array>
#include <cstdint>

#include "hil/plant/contact_problem.hpp"
#include "hil/plant/plant_scene.hpp"
#include "hil/plant/surface_motion.hpp"
#include "hil/plant/vehicle_model.hpp"

namespace sortie::hil {

/// Which parts meet in a contact.
struct ContactTag {
  std::uint64_t key{};    ///< part, object and feature: the same contact has the same key a step later
  double gap_m{};         ///< negative: penetration
  std::int16_t object{};  ///< index of the solid; -1 - index of a half-space
  std::uint8_t part{};    ///< as in rt::VehiclePart
};

/// Where the vehicle is: enough to find contacts.
struct BodyPose {
  Vec3 p_world_m;  ///< body's origin
  Matrix3 R_world_body;
};

/// The search. About 14 kB; no heap. The scene must outlive it.
class ContactFinder {
 public:
  ContactFinder(const VehicleModel& model, const PlantScene& scene);

  /// Fills `problem.contacts` (points, normals, targets, approach speeds for a step of `dt_s`) and the tags
  /// beside them. Contacts up to `margin_m` apart are listed. Impulses are those of the step before where the
  /// key is the same. Cost: 0.3 us on a plane; with solids 0.2 us and 0.3 to 1 us a pair that is near.
  void find(const BodyPose& pose, const MassState& state, const BeltMotion& belts, double margin_m,
            double dt_s, ContactProblem& problem);

  /// Keeps the answer for the next search.
  void remember(const ContactProblem& problem);

  const rt::FixedVector<ContactTag, kMaxContacts>& tags() const { return tags_; }

 private:
  void half_space_contacts(const BodyPose& pose, const MassState& state, int index);
  void track_on_plane(int part, const MassState& state, const Vec3& normal, double height_m, int index);
  void box_on_plane(const Vec3& normal, double height_m, int index);
  void solid_contacts(const BodyPose& pose, const MassState& state);
  void rescan(const Vec3& p_world_m);
  void add(int part, int object, std::uint32_t feature, const Vec3& point_m, const Vec3& normal,
           double gap_m);
  void warm(ContactPoint& contact, std::uint64_t key);

  struct Memory {
    std::uint64_t key;
    Vec3 impulse_ns;
  };

  const VehicleModel* model_;
  const PlantScene* scene_;
  double reach_m_{};  ///< of the vehicle around its origin, at any flipper angle
  Vec3 scan_centre_m_;
  bool scanned_{};
  std::array<std::uint16_t, PlantScene::kMaxSolids> near_{};
  std::uint32_t near_count_{};
  std::array<Memory, kMaxContacts> memory_{};
  std::uint32_t memory_count_{};
  std::uint32_t cursor_{};
  // Of the call under way.
  ContactList* contacts_{};
  const BeltMotion* belts_{};
  double margin_m_{};
  double dt_s_{};
  rt::FixedVector<ContactTag, kMaxContacts> tags_;
};

}  // namespace sortie::hil
