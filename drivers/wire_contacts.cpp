// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_contacts.hpp"

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

Status encode(const rt::ContactTruth& truth, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintContacts);
  writer.put(truth.stamp_ns);
  writer.put(truth.step_ns);
  writer.put_array(truth.flipper_asked_rad, rt::kFlippers);
  writer.put_array(truth.flipper_angle_rad, rt::kFlippers);
  writer.put_array(truth.flipper_torque_n_m, rt::kFlippers);
  writer.put(truth.dropped);
  writer.put_count(truth.contacts.size());
  for (const rt::TruthContact& contact : truth.contacts) writer.put(static_cast<std::int8_t>(contact.part));
  for (const rt::TruthContact& contact : truth.contacts) writer.put_array(contact.point_m, 3);
  for (const rt::TruthContact& contact : truth.contacts) writer.put_array(contact.normal, 3);
  for (const rt::TruthContact& contact : truth.contacts) writer.put(contact.normal_impulse_n_s);
  for (const rt::TruthContact& contact : truth.contacts) writer.put_array(contact.friction_impulse_n_s, 3);
  for (const rt::TruthContact& contact : truth.contacts) writer.put(contact.penetration_m);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::ContactTruth& truth) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintContacts); type != Status::ok) return type;
  rt::ContactTruth read;
  read.stamp_ns = reader.get<std::int64_t>();
  read.step_ns = reader.get<std::int64_t>();
  reader.get_array(read.flipper_asked_rad, rt::kFlippers);
  reader.get_array(read.flipper_angle_rad, rt::kFlippers);
  reader.get_array(read.flipper_torque_n_m, rt::kFlippers);
  read.dropped = reader.get<std::uint32_t>();
  const std::size_t count = reader.get_count(contacts_bytes(1) - contacts_bytes(0));
  if (reader.status() != Status::ok || message.size() != contacts_bytes(count)) return Status::malformed;
  if (count > rt::ContactTruth::kMaxContacts) return Status::full;
  static_cast<void>(read.contacts.resize(static_cast<std::uint32_t>(count)));
  for (rt::TruthContact& contact : read.contacts) {
    const auto part = reader.get<std::uint8_t>();
    if (part >= rt::kVehicleParts) return Status::malformed;
    contact.part = static_cast<rt::VehiclePart>(part);
  }
  for (rt::TruthContact& contact : read.contacts) reader.get_array(contact.point_m, 3);
  for (rt::TruthContact& contact : read.contacts) reader.get_array(contact.normal, 3);
  for (rt::TruthContact& contact : read.contacts) contact.normal_impulse_n_s = reader.get<double>();
  for (rt::TruthContact& contact : read.contacts) reader.get_array(contact.friction_impulse_n_s, 3);
  for (rt::TruthContact& contact : read.contacts) contact.penetration_m = reader.get<double>();
  if (const Status status = reader.finish(); status != Status::ok) return status;
  truth = read;
  return Status::ok;
}

}  // namespace sortie::drivers
