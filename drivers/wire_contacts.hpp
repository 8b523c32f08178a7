// SPDX-License-Identifier: BSD-3-Clause
// contacts_t: what a simulation knows of contacts and flippers. encode() and decode() are those of
// wire_fields.hpp; no heap.
#pragma once

#include <algorithm>
#include <cstdint>

#include "drivers/wire_fields.hpp"
#include "rt/contact_truth.hpp"

namespace sortie::drivers {

template <>
struct WireRules<rt::TruthContact> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("part", self.part);
    visit("point", self.point_m);
    visit("normal", self.normal);
    visit("normal_impulse", self.normal_impulse_n_s);
    visit("friction_impulse", self.friction_impulse_n_s);
    visit("penetration", self.penetration_m);
  }
};
template <>
struct WireRules<rt::ContactTruth> : WirePlain {
  static constexpr void members(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("step_ns", self.step_ns);
    visit("flipper_asked", self.flipper_asked_rad);
    visit("flipper_angle", self.flipper_angle_rad);
    visit("flipper_torque", self.flipper_torque_n_m);
    visit("dropped", self.dropped);
    visit("n", self.contacts);
  }
  static bool taken(const rt::ContactTruth& truth) {
    return std::all_of(truth.contacts.begin(), truth.contacts.end(), [](const rt::TruthContact& contact) {
      return static_cast<std::uint32_t>(contact.part) < rt::kVehicleParts;
    });
  }
};

/// Bytes of a message with `contacts` contacts.
constexpr std::size_t contacts_bytes(std::size_t contacts) {
  return kLeastBytes<rt::ContactTruth> + contacts * (1 + 11 * 8);
}
inline constexpr std::size_t kMaxContactsBytes = contacts_bytes(rt::ContactTruth::kMaxContacts);

}  // namespace sortie::drivers
