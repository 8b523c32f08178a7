// SPDX-License-Identifier: BSD-3-Clause
// Numbers from and to text, against integer arithmetic and the other direction.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "tests/firmware_like/temp_folder.hpp"
#include "toolchain/import/text_file.hpp"

using namespace sortie::firmware;

using namespace sortie::toolchain;

TEST_CASE("seconds are read to the nanosecond, whatever their form") {
  const auto ns = [](const char* text) {
    std::int64_t value = -1;
    INFO(text);
    REQUIRE(parse_seconds(text, value));
    return value;
  };
  CHECK(ns("1432235498.039332") == 1432235498039332000);
  CHECK(ns("1.403715529112143517e+09") == 1403715529112143517);
  CHECK(ns("3.8570532019138336e+003") == 3857053201914);
  CHECK(ns(" 12 ") == 12000000000);
  CHECK(ns("-0.5") == -500000000);
  CHECK(ns("+.25") == 250000000);
  CHECK(ns("1e-9") == 1);
  CHECK(ns("4e-10") == 0);
  CHECK(ns("5e-10") == 1);
  CHECK(ns("0.0000000014999") == 1);
  CHECK(ns("9223372036.854775807") == 9223372036854775807);
  CHECK(ns("0e400") == 0);
}

TEST_CASE("what is no time in seconds is refused") {
  std::int64_t value = 77;
  for (const char* text : {"", " ", "nan", "inf", "-", ".", "1.2.3", "1e", "1e+", "12s", "0x10", "9223372037",
                           "9223372036.854775808", "1e300", "1,5", "--1"}) {
    INFO(text);
    CHECK_FALSE(parse_seconds(text, value));
  }
  CHECK(value == 77);
}

TEST_CASE("seconds survive writing and reading") {
  std::mt19937_64 random(11);
  for (int i = 0; i < 20000; ++i) {
    const auto stamp = static_cast<std::int64_t>(random()) >> (random() % 63);
    std::int64_t back = 0;
    INFO(stamp);
    REQUIRE(parse_seconds(format_seconds(stamp), back));
    REQUIRE(back == stamp);
  }
}

TEST_CASE("doubles survive writing and reading") {
  std::mt19937_64 random(12);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    double back = 0.0;
    REQUIRE(parse_double(format_exact(value), back));
    REQUIRE(back == value);
  }
}

TEST_CASE("tables show numbers short, and nothing as a minus zero") {
  CHECK(format_short(3.2176) == "3.22");
  CHECK(format_short(0.0424) == "0.042");
  CHECK(format_short(184.4) == "184");
  CHECK(format_short(12.34) == "12.3");
  CHECK(format_short(5.0) == "5");
  CHECK(format_short(500000) == "500000");
  CHECK(format_short(1.2e-7) == "1.2e-07");
  CHECK(format_short(std::nan("")) == "-");
  CHECK(format_short(-HUGE_VAL) == "-inf");
  CHECK(format_fixed(-0.0004, 2) == "0.00");
  CHECK(group_digits(0) == "0");
  CHECK(group_digits(999) == "999");
  CHECK(group_digits(1000) == "1,000");
  CHECK(group_digits(307572) == "307,572");
  CHECK(group_digits(18446744073709551615u) == "18,446,744,073,709,551,615");
  CHECK(format_seconds(-1) == "-0.000000001");
  CHECK(shorten("track_odometry", 8) == "track_o~");
}

TEST_CASE("a text file gives whole lines, and keeps a cut one apart") {
  const sortie::testing::TempFolder folder;
  TextFile file(folder.write("a", "one\r\n\ntwo\nthr"));
  std::string_view line;
  REQUIRE(file.next(line));
  CHECK(line == "one");
  REQUIRE(file.next(line));
  CHECK(line.empty());
  REQUIRE(file.next(line));
  CHECK(line == "two");
  CHECK(file.line_number() == 3);
  CHECK_FALSE(file.next(line));
  CHECK(file.tail() == "thr");
  CHECK_THROWS_WITH(TextFile(folder.file("none")), Catch::Contains("no such file"));
  CHECK_THROWS_WITH(TextFile(folder.path()), Catch::Contains("folder"));
  CHECK_THROWS_WITH(TextFile(folder.write("b", std::string("ab\0c\n", 5))), Catch::Contains("offset 2"));
}
