// SPDX-License-Identifier: BSD-3-Clause
// candump logs: a recorded boat bus there and back byte for byte, every kind of frame, every kind of damage.
#include "drivers/candump.hpp"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

using namespace sortie;
using namespace sortie::drivers;

namespace {

/// A file of this name in a folder of its own, gone at the end.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content = "") {
    path_ = (std::filesystem::temp_directory_path() /
             ("sortie_candump_" + std::to_string(::getpid()) + "_" + std::to_string(++count()) + ".log"))
                .string();
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~ScratchFile() { std::remove(path_.c_str()); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  static int& count() {
    static int n = 0;
    return n;
  }
  std::string path_;
};

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string line_of(const CanFrame& frame, CandumpDigits digits = CandumpDigits::micro) {
  char text[kCandumpMaxLine + 1];
  return std::string(text, format_candump_line(frame, "can0", digits, text));
}

std::string reason_of(const std::string& line) {
  CandumpRecord record;
  CandumpFault fault;
  REQUIRE(parse_candump_line(line, record, fault) == Status::malformed);
  CHECK(std::string(fault.cure) != "");
  return fault.reason;
}

}  // namespace

TEST_CASE("a recorded bus is read and written again byte for byte") {
  const std::string path = std::string(SORTIE_DATA_DIR) + "/can_bus/n2k_a.candump";
  if (!std::filesystem::exists(path)) {
    WARN("skipped: " << path << " is not there");
    return;
  }
  ScratchFile copy;
  CandumpReader reader(path);
  CandumpWriter writer(copy.path());
  CandumpRecord record;
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  while (reader.next(record) == Status::ok) {
    if (first_ns == 0) first_ns = record.frame.stamp_ns;
    last_ns = record.frame.stamp_ns;
    CHECK(record.frame.flags == kCanExtended);
    REQUIRE(writer.write(record.frame, record.interface) == Status::ok);
  }
  REQUIRE(writer.close() == Status::ok);
  CHECK(reader.frames() == 34785);
  CHECK(reader.problems() == 0);
  CHECK(first_ns == 1408129200042000000);
  CHECK(last_ns == 1408129600025500000);
  CHECK(content_of(path) == content_of(copy.path()));
}

TEST_CASE("each kind of frame is read as can-utils means it and written as it stood") {
  struct Case {
    const char* line;
    std::uint32_t id;
    int size;
    int flags;
  };
  for (const Case& c : {Case{"(1700000000.000001) can0 07F#", 0x7F, 0, 0},
                        Case{"(1700000000.000001) can0 7FF#0011223344556677", 0x7FF, 8, 0},
                        Case{"(1700000000.000001) can0 0000007F#AB", 0x7F, 1, kCanExtended},
                        Case{"(1700000000.000001) can0 1FFFFFFF#AB", 0x1FFFFFFF, 1, kCanExtended},
                        Case{"(1700000000.000001) can0 123#R", 0x123, 0, kCanRemote},
                        Case{"(1700000000.000001) can0 123#R8", 0x123, 8, kCanRemote},
                        Case{"(1700000000.000001) can0 00000123#R2", 0x123, 2, kCanRemote | kCanExtended},
                        Case{"(1700000000.000001) can0 20000088#0000080000000000", 0x88, 8, kCanError}}) {
    INFO(c.line);
    CandumpRecord record;
    CandumpFault fault;
    REQUIRE(parse_candump_line(c.line, record, fault) == Status::ok);
    CHECK(record.frame.stamp_ns == 1700000000000001000);
    CHECK(record.frame.id == c.id);
    CHECK(record.frame.size == c.size);
    CHECK(record.frame.flags == c.flags);
    CHECK(std::string(record.interface) == "can0");
    CHECK(line_of(record.frame) == c.line);
  }
  CandumpRecord record;
  CandumpFault fault;
  REQUIRE(parse_candump_line("(0.123456789) vcan7 abc#dEaD  T\r", record, fault) == Status::malformed);
  REQUIRE(parse_candump_line("(0.123456789)  vcan7  7bc#dEaD T\r", record, fault) == Status::ok);
  CHECK(record.frame.stamp_ns == 123456789);
  CHECK(record.frame.id == 0x7BC);
  CHECK(record.frame.data[0] == 0xDE);
  CHECK(line_of(record.frame) == "(0000000000.123456) can0 7BC#DEAD");
  CHECK(line_of(record.frame, CandumpDigits::nano) == "(0000000000.123456789) can0 7BC#DEAD");
}

TEST_CASE("any frame written with nine decimals is read back as it was") {
  const std::uint64_t seed = 8;
  INFO("seed " << seed);
  std::mt19937_64 rng(seed);
  for (int i = 0; i < 20000; ++i) {
    CanFrame f;
    f.stamp_ns = static_cast<std::int64_t>(rng() % 9'223'372'035'999'999'999u);
    f.flags = static_cast<std::uint8_t>(rng() % 5);
    f.id = static_cast<std::uint32_t>(rng()) & (f.flags == 0 || f.flags == kCanRemote ? 0x7FFu : 0x1FFFFFFFu);
    f.size = static_cast<std::uint8_t>(rng() % 9);
    if ((f.flags & kCanRemote) == 0) {
      for (int k = 0; k < f.size; ++k) f.data[k] = static_cast<std::uint8_t>(rng() & 0xFF);
    }
    const std::string line = line_of(f, CandumpDigits::nano);
    CandumpRecord record;
    CandumpFault fault;
    INFO(line);
    REQUIRE(parse_candump_line(line, record, fault) == Status::ok);
    CHECK(record.frame.stamp_ns == f.stamp_ns);
    CHECK(record.frame.id == f.id);
    CHECK(record.frame.size == f.size);
    CHECK(record.frame.flags == f.flags);
    CHECK(std::equal(f.data, f.data + 8, record.frame.data));
  }
}

TEST_CASE("a damaged line is refused for the right reason") {
  CHECK(reason_of("hello") == "the line does not begin with a time in parentheses");
  CHECK(reason_of("(1.5) can0 123#00") == "the time is not seconds with 6 or 9 decimals");
  CHECK(reason_of("(-1.500000) can0 123#00") == "the time is not seconds with 6 or 9 decimals");
  CHECK(reason_of("(1.500000") == "the time is not seconds with 6 or 9 decimals");
  CHECK(reason_of("(9223372036.000000) can0 123#00") == "the time is beyond the year 2262");
  CHECK(reason_of("(99999999999999999999.000000) can0 123#00") == "the time is beyond the year 2262");
  CHECK(reason_of("(18446744073709551617.000000) can0 123#00") == "the time is beyond the year 2262");
  CHECK(reason_of("(1.500000)") == "there is no interface name of 1 to 15 characters behind the time");
  CHECK(reason_of("(1.500000) sixteencharacter 1#") ==
        "there is no interface name of 1 to 15 characters behind the time");
  CHECK(reason_of("(1.500000) can0 12#00") == "the identifier does not have 3 or 8 hexadecimal digits");
  CHECK(reason_of("(1.500000) can0 #00") == "the identifier does not have 3 or 8 hexadecimal digits");
  CHECK(reason_of("(1.500000) can0 FFF#00") == "an identifier of 3 digits is above 7FF");
  CHECK(reason_of("(1.500000) can0 80000000#00") == "the identifier is above 1FFFFFFF");
  CHECK(reason_of("(1.500000) can0 123") == "there is no # behind the identifier");
  CHECK(reason_of("(1.500000) can0 123##100") ==
        "this is a CAN FD frame (##), and only classical CAN is read");
  CHECK(reason_of("(1.500000) can0 123#001") == "the data end in half a byte");
  CHECK(reason_of("(1.500000) can0 123#001122334455667788") == "there are more than 8 data bytes");
  CHECK(reason_of("(1.500000) can0 123#R9") == "a remote frame asks for more than 8 bytes");
  CHECK(reason_of("(1.500000) can0 20000001#R") == "an error frame cannot be a remote frame");
  CHECK(reason_of("(1.500000) can0 123#00 X") ==
        "there are characters behind the frame that do not belong there");
  CHECK(reason_of(std::string("(1.500000) can0 123#00\0", 23)) ==
        "there are characters behind the frame that do not belong there");
}

TEST_CASE("the reader names path and line, and goes on behind the damage") {
  const ScratchFile file(
      "(1.000000) can0 123#00\n"
      "\n"
      "(2.000000) can0 123##000\r\n"
      "(3.000000) can0 123#01\r\n" +
      std::string(5000, 'x') +
      "\n"
      "(4.000000) can0 123#02\n"
      "(5.000000) can0 123#03");
  CandumpReader reader(file.path());
  CandumpRecord record;
  REQUIRE(reader.next(record) == Status::ok);
  REQUIRE(reader.next(record) == Status::malformed);
  CHECK_THAT(reader.problem(), Catch::Contains(file.path() + ", line 3: ") && Catch::Contains("CAN FD") &&
                                   Catch::Contains("grep -v"));
  REQUIRE(reader.next(record) == Status::ok);
  CHECK(record.frame.data[0] == 1);
  REQUIRE(reader.next(record) == Status::malformed);
  CHECK_THAT(reader.problem(), Catch::Contains(", line 5: ") && Catch::Contains("longer than 191"));
  REQUIRE(reader.next(record) == Status::ok);
  CHECK(record.frame.data[0] == 2);
  CHECK(reader.line() == 6);
  REQUIRE(reader.next(record) == Status::malformed);
  CHECK_THAT(reader.problem(), Catch::Contains(", line 7: the last line has no line end"));
  CHECK(reader.next(record) == Status::empty);
  CHECK(reader.next(record) == Status::empty);
  CHECK(reader.frames() == 3);
  CHECK(reader.problems() == 3);
}

TEST_CASE("a log cut off at any byte never yields a frame that was not in it") {
  const std::string whole =
      "(1.000000) can0 123#0011\n(2.000000) can0 00000456#AABBCCDD\n(3.000000) can0 789#R4\n";
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    const ScratchFile file(whole.substr(0, cut));
    CandumpReader reader(file.path());
    CandumpRecord record;
    std::string again;
    Status status = Status::ok;
    while ((status = reader.next(record)) == Status::ok) again += line_of(record.frame) + "\n";
    INFO("cut at " << cut);
    // What was given out are the first whole lines (their times are written with ten digits).
    std::string expected;
    for (std::size_t at = 0; at < cut;) {
      const std::size_t end = whole.find('\n', at);
      if (end >= cut) break;
      expected += "(000000000" + whole.substr(at + 1, end - at);
      at = end + 1;
    }
    CHECK(again == expected);
    CHECK(status == (cut == 0 || whole[cut - 1] == '\n' ? Status::empty : Status::malformed));
  }
}

TEST_CASE("files that cannot be opened are named with the cure") {
  CHECK_THROWS_WITH(CandumpReader("/nonexistent/a.log"), Catch::Contains("/nonexistent/a.log") &&
                                                             Catch::Contains("No such file") &&
                                                             Catch::Contains("candump -l"));
  CHECK_THROWS_WITH(CandumpReader("/"), Catch::Contains("is a folder"));
  CHECK_THROWS_WITH(CandumpWriter("/nonexistent/a.log"), Catch::Contains("cannot be written"));
}

TEST_CASE("what a log cannot hold is not written") {
  CanFrame f;
  f.stamp_ns = -1;
  CHECK(line_of(f) == "");
  f.stamp_ns = 0;
  f.size = 9;
  CHECK(line_of(f) == "");
  f.size = 0;
  f.id = 0x800;
  CHECK(line_of(f) == "");
  f.id = 0;
  for (unsigned bit = 0x08; bit <= 0x80; bit *= 2) {
    f.flags = static_cast<std::uint8_t>(bit);
    CHECK(line_of(f) == "");
  }
  f.flags = 0;
  char text[10];
  CHECK(format_candump_line(f, "can0", CandumpDigits::micro, text) == 0);
  char room[kCandumpMaxLine];
  CHECK(format_candump_line(f, "can 0", CandumpDigits::micro, room) == 0);
  CHECK(format_candump_line(f, "", CandumpDigits::micro, room) == 0);
  f.stamp_ns = INT64_MAX;
  CHECK(format_candump_line(f, "can0", CandumpDigits::micro, room) > 0);
}

TEST_CASE("a full disk is reported by the writer") {
  if (!std::filesystem::exists("/dev/full")) {
    WARN("skipped: there is no /dev/full");
    return;
  }
  CandumpWriter writer("/dev/full");
  Status status = Status::ok;
  for (int i = 0; i < 10000 && status == Status::ok; ++i) status = writer.write(CanFrame{});
  if (status == Status::ok) status = writer.close();
  CHECK(status == Status::full);
}
