// SPDX-License-Identifier: BSD-3-Clause
// contacts_t against lcm-gen's code: same bytes, every bit back, nothing taken that is damaged.
#include "drivers/wire_truth.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "sortie/contacts_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

namespace {

double any_bits(std::mt19937_64& random) {
  const std::uint64_t bits = random();
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

rt::ContactTruth any_contacts(std::mt19937_64& random, std::uint32_t count) {
  rt::ContactTruth truth;
  truth.stamp_ns = static_cast<std::int64_t>(random());
  truth.step_ns = static_cast<std::int64_t>(random());
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    truth.flipper_asked_rad[i] = any_bits(random);
    truth.flipper_angle_rad[i] = any_bits(random);
    truth.flipper_torque_n_m[i] = any_bits(random);
  }
  truth.dropped = static_cast<std::uint32_t>(random() & 0x7fffffffu);
  REQUIRE(truth.contacts.resize(count));
  for (rt::TruthContact& contact : truth.contacts) {
    contact.part = static_cast<rt::VehiclePart>(random() % rt::kVehicleParts);
    for (int k = 0; k < 3; ++k) {
      contact.point_m[k] = any_bits(random);
      contact.normal[k] = any_bits(random);
      contact.friction_impulse_n_s[k] = any_bits(random);
    }
    contact.normal_impulse_n_s = any_bits(random);
    contact.penetration_m = any_bits(random);
  }
  return truth;
}

std::vector<double> three(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

contacts_t twin_of(const rt::ContactTruth& truth) {
  contacts_t twin{};
  twin.stamp_ns = truth.stamp_ns;
  twin.step_ns = truth.step_ns;
  std::memcpy(twin.flipper_asked, truth.flipper_asked_rad, sizeof twin.flipper_asked);
  std::memcpy(twin.flipper_angle, truth.flipper_angle_rad, sizeof twin.flipper_angle);
  std::memcpy(twin.flipper_torque, truth.flipper_torque_n_m, sizeof twin.flipper_torque);
  twin.dropped = static_cast<std::int32_t>(truth.dropped);
  twin.n = static_cast<std::int32_t>(truth.contacts.size());
  for (const rt::TruthContact& contact : truth.contacts) {
    twin.part.push_back(static_cast<std::int8_t>(contact.part));
    twin.point.push_back(three(contact.point_m));
    twin.normal.push_back(three(contact.normal));
    twin.normal_impulse.push_back(contact.normal_impulse_n_s);
    twin.friction_impulse.push_back(three(contact.friction_impulse_n_s));
    twin.penetration.push_back(contact.penetration_m);
  }
  return twin;
}

Bytes encoded(const rt::ContactTruth& truth) {
  Bytes bytes(kMaxContactsBytes);
  std::size_t size = 0;
  REQUIRE(encode(truth, bytes, size) == Status::ok);
  bytes.resize(size);
  return bytes;
}

}  // namespace

TEST_CASE("contacts are written as lcm-gen writes them and come back bit for bit") {
  constexpr unsigned kSeed = 5;
  INFO("seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (std::uint32_t count = 0; count <= rt::ContactTruth::kMaxContacts; ++count) {
    const rt::ContactTruth truth = any_contacts(random, count);
    const Bytes bytes = encoded(truth);
    REQUIRE(bytes.size() == contacts_bytes(count));
    REQUIRE(bytes == generated_bytes(twin_of(truth)));
    rt::ContactTruth back;
    REQUIRE(decode(bytes, back) == Status::ok);
    REQUIRE(back.contacts.size() == count);
    REQUIRE(encoded(back) == bytes);
    Bytes small(bytes.size() - 1);
    std::size_t none = 1;
    REQUIRE(encode(truth, small, none) == Status::full);
    REQUIRE(none == 0);
  }
}

TEST_CASE("damaged contacts are refused and change nothing") {
  std::mt19937_64 random(6);
  const Bytes good = encoded(any_contacts(random, 9));
  rt::ContactTruth kept;
  kept.stamp_ns = 42;
  for (std::size_t size = 0; size < good.size(); ++size) {
    const Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    REQUIRE(decode(cut, kept) == Status::malformed);
  }
  Bytes longer = good;
  longer.push_back(0);
  CHECK(decode(longer, kept) == Status::malformed);
  Bytes other = good;
  other[0] ^= 1;
  CHECK(decode(other, kept) == Status::bad_checksum);
  Bytes part = good;
  part[contacts_bytes(0)] = 7;  // the parts end with 6
  CHECK(decode(part, kept) == Status::malformed);
  contacts_t many = twin_of(any_contacts(random, rt::ContactTruth::kMaxContacts));
  many.n += 1;
  many.part.push_back(0);
  many.point.push_back({0, 0, 0});
  many.normal.push_back({0, 0, 0});
  many.normal_impulse.push_back(0);
  many.friction_impulse.push_back({0, 0, 0});
  many.penetration.push_back(0);
  CHECK(decode(generated_bytes(many), kept) == Status::full);
  CHECK(kept.stamp_ns == 42);
  CHECK(kept.contacts.empty());
}
