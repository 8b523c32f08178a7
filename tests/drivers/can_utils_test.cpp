// SPDX-License-Identifier: BSD-3-Clause
// Our candump files through can-utils' own converters, and back: its log2asc must read what we write, and we
// what its asc2log writes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "drivers/candump.hpp"
#include "tests/firmware_like/temp_folder.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

std::vector<CanFrame> random_can_frames(std::mt19937_64& random, std::size_t count) {
  std::vector<CanFrame> frames;
  rt::Nanoseconds stamp_ns = 1'700'000'000'000'000'000;
  for (std::size_t i = 0; i < count; ++i) {
    CanFrame frame;
    stamp_ns += static_cast<rt::Nanoseconds>(1000 * (1 + random() % 100'000));  // the text has microseconds
    frame.stamp_ns = stamp_ns;
    const bool extended = random() % 3 == 0;
    frame.id = static_cast<std::uint32_t>(random() % (extended ? 0x2000'0000u : 0x800u));
    if (extended) frame.flags = kCanExtended;
    frame.size = static_cast<std::uint8_t>(random() % 9);
    if (random() % 10 == 0) {
      frame.flags |= kCanRemote;
    } else {
      for (unsigned b = 0; b < frame.size; ++b) frame.data[b] = static_cast<std::uint8_t>(random());
    }
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace

TEST_CASE("frames go through can-utils' log2asc and asc2log and come back") {
  if (std::system("command -v log2asc >/dev/null && command -v asc2log >/dev/null") != 0) {
    WARN("skipped: can-utils is not installed. Cure: toolchain/install test");
    return;
  }
  constexpr unsigned kSeed = 20'111;
  CAPTURE(kSeed);
  std::mt19937_64 random(kSeed);
  const std::vector<CanFrame> frames = random_can_frames(random, 3000);
  const sortie::testing::TempFolder folder;
  {
    CandumpWriter writer(folder.file("ours.log"));
    for (const CanFrame& frame : frames) REQUIRE(writer.write(frame) == Status::ok);
    REQUIRE(writer.close() == Status::ok);
  }
  // The .asc has the log's date as text in the machine's language, which asc2log may not read: times are
  // compared from the first frame on.
  const std::string convert = "log2asc -I " + folder.file("ours.log") + " -O " + folder.file("a.asc") +
                              " can0 && asc2log -I " + folder.file("a.asc") + " -O " +
                              folder.file("theirs.log") + " 2>" + folder.file("errors");
  REQUIRE(std::system(convert.c_str()) == 0);
  CandumpReader reader(folder.file("theirs.log"));
  CandumpRecord record;
  rt::Nanoseconds first_ns = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CAPTURE(i);
    REQUIRE(reader.next(record) == Status::ok);
    if (i == 0) first_ns = record.frame.stamp_ns;
    CHECK(record.frame.id == frames[i].id);
    CHECK(record.frame.flags == frames[i].flags);
    CHECK(record.frame.size == frames[i].size);
    CHECK(std::equal(frames[i].data, frames[i].data + 8, record.frame.data));
    CHECK(record.frame.stamp_ns - first_ns == frames[i].stamp_ns - frames[0].stamp_ns);
  }
  CHECK(reader.next(record) == Status::empty);
  CHECK(reader.problems() == 0);
}
