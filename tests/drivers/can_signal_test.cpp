// SPDX-License-Identifier: BSD-3-Clause
// Tables made of .dbc files against a twin that reads the file by itself and moves one bit at a time.
#include "drivers/can_signal.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "tests/drivers/odd_dbc.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

struct Twin {
  std::uint64_t message{};
  std::string name;
  unsigned start{};
  unsigned length{};
  bool motorola{};
  bool has_sign{};
};

std::vector<Twin> twins_of(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file);
  const std::regex head("BO_ (\\d+) .*");
  const std::regex signal(" SG_ (\\w+) .*?(\\d+)\\|(\\d+)@([01])([+-]).*");
  std::vector<Twin> found;
  std::uint64_t message = 0;
  for (std::string line; std::getline(file, line);) {
    std::smatch m;
    if (std::regex_match(line, m, head)) message = std::stoull(m[1]);
    if (std::regex_match(line, m, signal))
      found.push_back({message, m[1], static_cast<unsigned>(std::stoul(m[2])),
                       static_cast<unsigned>(std::stoul(m[3])), m[4] == "0", m[5] == "-"});
  }
  return found;
}

// Places of a signal's bits, the lowest first.
std::vector<unsigned> places(const Twin& twin) {
  std::vector<unsigned> all;
  unsigned at = twin.start;
  for (unsigned i = 0; i < twin.length; ++i) {
    if (twin.motorola) {
      all.insert(all.begin(), at);
      at = at % 8 == 0 ? at + 15 : at - 1;
    } else {
      all.push_back(at++);
    }
  }
  return all;
}

bool bit(const CanFrame& frame, unsigned place) { return ((frame.data[place / 8] >> place % 8) & 1) != 0; }

std::int64_t read_slowly(const CanFrame& frame, const Twin& twin) {
  std::uint64_t raw = 0;
  unsigned i = 0;
  for (const unsigned place : places(twin)) raw |= std::uint64_t{bit(frame, place)} << i++;
  for (; twin.has_sign && i < 64 && bit(frame, places(twin).back()); ++i) raw |= std::uint64_t{1} << i;
  return static_cast<std::int64_t>(raw);
}

const CanMessage& message_of(std::uint64_t number) {
  for (const CanMessage& message : odd::kMessages) {
    if (message.id + (message.extended ? 0x80000000u : 0u) == number) return message;
  }
  throw std::runtime_error("no such message");
}

const CanSignal& signal_of(const CanMessage& message, std::string_view name) {
  for (std::size_t i = 0; i < message.field_count; ++i) {
    if (name == message.fields[i].name) return message.fields[i];
  }
  throw std::runtime_error("no such signal");
}

}  // namespace

TEST_CASE("every signal of a database is read and written as a twin does it bit by bit") {
  const std::uint64_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  const std::vector<Twin> twins = twins_of(std::string(SORTIE_SOURCE_DIR) + "/tests/drivers/odd.dbc");
  REQUIRE(twins.size() == 20);
  std::size_t wrong = 0;
  for (const Twin& twin : twins) {
    const CanSignal& signal = signal_of(message_of(twin.message), twin.name);
    // A float's bits have no sign of their own.
    Twin plain = twin;
    plain.has_sign = signal.value == CanValue::signed_whole;
    for (int i = 0; i < 2000; ++i) {
      CanFrame frame;
      for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
      if (read_can_field(frame, signal) != read_slowly(frame, plain)) ++wrong;
      const CanFrame before = frame;
      const auto raw = static_cast<std::int64_t>(random());
      write_can_field(frame, signal, raw);
      const std::vector<unsigned> mine = places(plain);
      for (unsigned place = 0; place < 64; ++place) {
        const auto at = std::find(mine.begin(), mine.end(), place);
        const bool expected = at == mine.end() ? bit(before, place) : ((raw >> (at - mine.begin())) & 1) != 0;
        if (bit(frame, place) != expected) ++wrong;
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("signals of both byte orders give the values that were worked out by hand") {
  CanFrame frame;
  const std::uint8_t bytes[8] = {0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0};
  std::memcpy(frame.data, bytes, sizeof bytes);
  frame.size = 8;
  // 12 34 as Motorola bits: 0001 0010 0011 | 0100 0101 0110.
  CHECK(read_can_field(frame, signal_of(odd::kMotorola, "high")) == 0x123);
  CHECK(physical_can_field(frame, signal_of(odd::kMotorola, "low")) == 0x456 * 0.25 + 10);
  CHECK(read_can_field(frame, signal_of(odd::kWhole, "all")) ==
        static_cast<std::int64_t>(0xF0DEBC9A78563412u));
  CHECK(physical_can_field(frame, signal_of(odd::kWhole, "all")) == 17356517385562371090.0);
  CHECK(read_can_field(frame, signal_of(odd::kWholeBack, "all")) == 0x123456789ABCDEF0);
  // Bits 5 to 11 of 0x3412: 0100000, with a sign of 0.
  CHECK(physical_can_field(frame, signal_of(odd::kIntel, "seven_across")) == 0x20 * 0.5 - 3);
  CHECK(physical_can_field(frame, signal_of(odd::kIntel, "last")) == -1.0);
}

TEST_CASE("floats, multiplexers and identifiers of 29 bits are in the table") {
  CanFrame frame;
  REQUIRE(set_can_field(frame, signal_of(odd::kFloats, "first"), -1.5) == Status::ok);
  REQUIRE(set_can_field(frame, signal_of(odd::kFloats, "second"), 3.0) == Status::ok);
  const std::uint8_t bytes[8] = {0x00, 0x00, 0xC0, 0xBF,
                                 0x3F, 0xC0, 0x00, 0x00};  // -1.5, and 1.5 the other way round
  CHECK(std::memcmp(frame.data, bytes, sizeof bytes) == 0);
  CHECK(physical_can_field(frame, signal_of(odd::kFloats, "second")) == 3.0);
  REQUIRE(set_can_field(frame, signal_of(odd::kWideFloat, "all"), 1e300) == Status::ok);
  CHECK(physical_can_field(frame, signal_of(odd::kWideFloat, "all")) == 1e300);
  CHECK(set_can_field(frame, signal_of(odd::kFloats, "first"), 1e300) == Status::out_of_range);

  frame = {};
  frame.data[0] = 3;
  CHECK_FALSE(has_can_field(frame, odd::kChoice, signal_of(odd::kChoice, "a")));
  CHECK(has_can_field(frame, odd::kChoice, signal_of(odd::kChoice, "b")));
  CHECK(has_can_field(frame, odd::kChoice, signal_of(odd::kChoice, "always")));
  CHECK(odd::kLongName.extended);
  CHECK(odd::kLongName.id == 2566844926u - 0x80000000u);
  frame.id = odd::kLongName.id;
  frame.size = 3;
  CHECK_FALSE(odd::kLongName.is(frame));
  frame.flags = kCanExtended;
  CHECK(odd::kLongName.is(frame));
  CHECK(std::string_view(signal_of(odd::kIntel, "one").meaning) == "a text of two lines with a \"word\"");
}

TEST_CASE("what does not fit a signal is refused and changes nothing") {
  CanFrame frame;
  const CanSignal& turn = signal_of(odd::kIntel, "thirty");
  REQUIRE(set_can_field(frame, turn, -12.3456) == Status::ok);
  CHECK(read_can_field(frame, turn) == -12346);
  const CanFrame before = frame;
  CHECK(set_can_field(frame, turn, 100.001) == Status::out_of_range);
  CHECK(set_can_field(frame, turn, std::numeric_limits<double>::quiet_NaN()) == Status::not_finite);
  CHECK(set_can_field(frame, signal_of(odd::kIntel, "seven_across"), 29.0) ==
        Status::out_of_range);  // 64 steps
  CHECK(set_can_field(frame, signal_of(odd::kIntel, "one"), -1.0) == Status::out_of_range);
  CHECK(set_can_field(frame, signal_of(odd::kWhole, "all"), 18446744073709551616.0) == Status::out_of_range);
  CHECK(std::memcmp(frame.data, before.data, sizeof frame.data) == 0);
  REQUIRE(set_can_field(frame, signal_of(odd::kIntel, "seven_across"), 28.5) == Status::ok);
  CHECK(physical_can_field(frame, signal_of(odd::kIntel, "seven_across")) == 28.5);
  CHECK(physical_can_field(frame, turn) == Approx(-12.346));
}
