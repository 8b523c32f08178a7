// SPDX-License-Identifier: BSD-3-Clause
// Damaged logs: damage costs only what it hits, and its place is named.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "tests/drivers/log_items.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

TEST_CASE("a log cut at any byte keeps every complete event and names the place") {
  TempFile file("cut.lcm");
  const std::vector<Item> items = some_items(6, 3);
  write_log(file.path(), items);
  const Bytes bytes = file.read();
  std::vector<std::size_t> ends{0};
  for (const Item& item : items) {
    ends.push_back(ends.back() + kLcmLogHeaderBytes + item.channel.size() + item.data.size());
  }
  REQUIRE(ends.back() == bytes.size());
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    std::size_t whole = 0;
    while (whole + 1 < ends.size() && ends[whole + 1] <= length) ++whole;
    // Exactly as long as the cut log, so that a sanitizer sees any read behind it.
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    LcmLogCursor cursor(cut);
    LogEvent event;
    for (std::size_t i = 0; i < whole; ++i) {
      REQUIRE(cursor.next(event) == Status::ok);
      REQUIRE(same(event, items[i]));
    }
    if (length == ends[whole]) {
      REQUIRE(cursor.next(event) == Status::empty);
      continue;
    }
    REQUIRE(cursor.next(event) == Status::malformed);
    REQUIRE(cursor.problem().offset == ends[whole]);
    REQUIRE(cursor.problem().event == whole);
    REQUIRE(cursor.problem().skipped == length - ends[whole]);
    REQUIRE(cursor.next(event) == Status::malformed);
  }
}

TEST_CASE("random damage never loses an event before it") {
  const std::vector<Item> items = some_items(40, 4);
  TempFile file("damage.lcm");
  write_log(file.path(), items);
  const Bytes clean = file.read();
  const unsigned seed = 20;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = clean;
    const std::size_t at = random() % bytes.size();
    const std::size_t run = 1 + random() % 40;
    for (std::size_t i = at; i < std::min(bytes.size(), at + run); ++i)
      bytes[i] = static_cast<std::uint8_t>(random());
    LcmLogCursor cursor(bytes);
    LogEvent event;
    std::size_t intact_before = 0;
    std::size_t offset = 0;
    for (const Item& item : items) {
      offset += kLcmLogHeaderBytes + item.channel.size() + item.data.size();
      if (offset <= at) ++intact_before;
    }
    for (std::size_t found = 0; found < intact_before; ++found) {
      REQUIRE(cursor.next(event) == Status::ok);
      REQUIRE(same(event, items[found]));
    }
    while (cursor.next(event) == Status::ok) REQUIRE(cursor.position() <= bytes.size());
  }
}

TEST_CASE("lengths that promise gigabytes are refused where they stand") {
  TempFile file("hostile.lcm");
  const std::vector<Item> items = some_items(3, 5);
  write_log(file.path(), items);
  const Bytes clean = file.read();
  for (const std::size_t field : {std::size_t{20}, std::size_t{24}}) {  // channel length, data length
    for (const int top : {0x7f, 0x80, 0xff}) {
      Bytes bytes = clean;
      for (std::size_t i = 0; i < 4; ++i) bytes[field + i] = static_cast<std::uint8_t>(i == 0 ? top : 0xff);
      LcmLogCursor stop(bytes);
      LogEvent event;
      REQUIRE(stop.next(event) == Status::malformed);
      CHECK(stop.problem().offset == 0);
      CHECK(stop.problem().describe().find("impossible") != std::string::npos);
    }
  }
}

TEST_CASE("an event without a channel is damage") {
  TempFile file("nameless.lcm");
  const std::vector<Item> items = some_items(2, 8);
  write_log(file.path(), items);
  Bytes bytes = file.read();
  bytes[23] = 0;  // the channel's length
  LcmLogCursor cursor(bytes);
  LogEvent event;
  CHECK(cursor.next(event) == Status::malformed);
}
