// SPDX-License-Identifier: BSD-3-Clause
// Frame lengths against a bit string built and stuffed the slow way; arbitration keys against bit comparison.
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <string>

#include "drivers/can_timing.hpp"

using namespace sortie::drivers;

namespace {

std::string binary(std::uint64_t value, int width) {
  std::string text;
  for (int i = width - 1; i >= 0; --i) text += ((value >> i) & 1u) != 0 ? '1' : '0';
  return text;
}

/// The arbitration and control fields as text, from the layout in the standard.
std::string header(const CanFrame& f) {
  const bool remote = (f.flags & kCanRemote) != 0;
  std::string bits = "0";
  if ((f.flags & kCanExtended) != 0) {
    bits += binary(f.id >> 18, 11) + "11" + binary(f.id & 0x3FFFF, 18) + (remote ? "1" : "0") + "00";
  } else {
    bits += binary(f.id, 11) + (remote ? "1" : "0") + "00";
  }
  return bits;
}

/// Remainder of bits * x^15 by the CAN polynomial, by long division on text.
std::string crc15(const std::string& bits) {
  const std::string divisor = "1100010110011001";
  std::string work = bits + std::string(15, '0');
  for (std::size_t i = 0; i + 15 < work.size(); ++i) {
    if (work[i] == '0') continue;
    for (std::size_t k = 0; k < 16; ++k) work[i + k] = work[i + k] == divisor[k] ? '0' : '1';
  }
  return work.substr(work.size() - 15);
}

std::string stuffed(const CanFrame& f) {
  std::string bits = header(f) + binary(f.size, 4);
  if ((f.flags & kCanRemote) == 0) {
    for (int i = 0; i < f.size; ++i) bits += binary(f.data[i], 8);
  }
  bits += crc15(bits);
  std::string out;
  for (const char bit : bits) {
    out += bit;
    if (out.size() >= 5 && out.substr(out.size() - 5) == std::string(5, bit)) {
      out += bit == '0' ? '1' : '0';
    }
  }
  return out;
}

CanFrame random_frame(std::mt19937_64& rng) {
  CanFrame f;
  const std::uint64_t kind = rng();
  f.flags = static_cast<std::uint8_t>((kind & 1u) | ((kind >> 1) % 8 == 0 ? 2u : 0u));
  f.id = static_cast<std::uint32_t>(rng()) & ((f.flags & kCanExtended) != 0 ? 0x1FFFFFFFu : 0x7FFu);
  f.size = static_cast<std::uint8_t>(rng() % 9);
  const std::uint64_t fill = rng() % 4;  // runs of equal bits are the interesting case
  for (auto& byte : f.data) {
    byte = static_cast<std::uint8_t>(fill == 0 ? 0x00 : fill == 1 ? 0xFF : fill == 2 ? 0xE0 : rng() & 0xFF);
  }
  return f;
}

}  // namespace

TEST_CASE("a frame is as long as its bits, CRC and stuff bits written out one by one") {
  const std::uint64_t seed = 20261121;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  for (int i = 0; i < 20000; ++i) {
    const CanFrame f = random_frame(rng);
    const int expected = static_cast<int>(stuffed(f).size()) + 10;
    INFO("id " << std::hex << f.id << " flags " << int{f.flags} << std::dec << " size " << int{f.size});
    REQUIRE(can_frame_bits(f) == expected);
    const int data = (f.flags & kCanRemote) != 0 ? 0 : f.size;
    REQUIRE(can_frame_bits(f) <= can_frame_bits_worst(data, (f.flags & kCanExtended) != 0));
    REQUIRE(can_frame_bits(f) >= ((f.flags & kCanExtended) != 0 ? 64 : 44) + 8 * data);
  }
}

TEST_CASE("the longest frames have the lengths of the literature") {
  // Davis, Burns, Bril, Lukkien 2007: 135 bits for 8 bytes with 11-bit identifiers, 160 with 29, each with 3
  // bits of intermission.
  CHECK(can_frame_bits_worst(8, false) + kCanIntermissionBits == 135);
  CHECK(can_frame_bits_worst(8, true) + kCanIntermissionBits == 160);
  CHECK(can_frame_bits_worst(0, false) + kCanIntermissionBits == 55);
}

TEST_CASE("the arbitration key orders frames as their bits do on the bus") {
  const std::uint64_t seed = 7;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  for (int i = 0; i < 20000; ++i) {
    CanFrame a = random_frame(rng);
    CanFrame b = random_frame(rng);
    if (i % 2 == 0) {  // same base identifier: the later bits decide
      const std::uint32_t base = (a.flags & kCanExtended) != 0 ? a.id >> 18 : a.id;
      b.id = (b.flags & kCanExtended) != 0 ? base << 18 | (b.id & 0x3FFFF) : base;
    }
    std::string bits_a = header(a);
    std::string bits_b = header(b);
    bits_a.resize(32, '0');
    bits_b.resize(32, '0');
    REQUIRE((can_arbitration_key(a) < can_arbitration_key(b)) == (bits_a < bits_b));
  }
}

TEST_CASE("a standard remote frame beats an extended frame that begins with the same identifier") {
  CanFrame remote;
  remote.id = 0x123;
  remote.flags = kCanRemote;
  CanFrame extended;
  extended.id = 0x123u << 18;
  extended.flags = kCanExtended;
  CHECK(can_arbitration_key(remote) < can_arbitration_key(extended));
}

TEST_CASE("a frame no controller could send is not valid") {
  CanFrame f;
  f.id = 0x7FF;
  f.size = 8;
  CHECK(can_frame_valid(f));
  f.size = 9;
  CHECK_FALSE(can_frame_valid(f));
  f.size = 8;
  f.id = 0x800;
  CHECK_FALSE(can_frame_valid(f));
  f.flags = kCanExtended;
  CHECK(can_frame_valid(f));
  f.id = 0x20000000;
  CHECK_FALSE(can_frame_valid(f));
  f.id = 0;
  f.flags = kCanError;
  CHECK_FALSE(can_frame_valid(f));
  f.flags = 0x40;
  CHECK_FALSE(can_frame_valid(f));
}
