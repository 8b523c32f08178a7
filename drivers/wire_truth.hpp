// SPDX-License-Identifier: BSD-3-Clause
// What a simulation knows: of contacts and flippers as contacts_t, whose encode() and decode() are those of
// wire_fields.hpp; of the inertial sensor and the encoders as a custom_t on its own channel. No heap.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/channels.hpp"
#include "drivers/wire_fields.hpp"
#include "rt/contact_truth.hpp"
#include "rt/sensor_truth.hpp"

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

/// Names and types of the numbers in the message of rt::SensorTruth, in their order.
inline constexpr std::string_view kSensorTruthFields =
    "stamp_ns:i64,gyr_rad_s[0]:f64,gyr_rad_s[1]:f64,gyr_rad_s[2]:f64,acc_m_s2[0]:f64,acc_m_s2[1]:f64,acc_m_"
    "s2[2]:f64,"
    "gyr_bias_rad_s[0]:f64,gyr_bias_rad_s[1]:f64,gyr_bias_rad_s[2]:f64,acc_bias_m_s2[0]:f64,acc_bias_m_s2[1]:"
    "f64,"
    "acc_bias_m_s2[2]:f64,belt_left_m:f64,belt_right_m:f64,ground_left_m:f64,ground_right_m:f64";

/// Room for such a message.
inline constexpr std::size_t kMaxSensorTruthBytes = 768;

/// Status: ok, full (`out` is too small; `size` is then 0). `seq` counts the records.
[[nodiscard]] Status encode(const rt::SensorTruth& truth, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// Status: ok; bad_checksum (another type); malformed (other fields or lengths). `truth` is unchanged unless
/// ok.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SensorTruth& truth) noexcept;

}  // namespace sortie::drivers
