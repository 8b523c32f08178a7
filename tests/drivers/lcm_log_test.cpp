// SPDX-License-Identifier: BSD-3-Clause
// The event log: liblcm reads what we write and we read what it writes; refusals and full disks are told in
// one line.
#include <lcm/lcm.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "tests/drivers/log_items.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

TEST_CASE("a log that we write is read by us and by liblcm") {
  TempFile file("ours.lcm");
  std::vector<Item> items = some_items(300, 1);
  items.push_back({"BIG", 5, Bytes(100'000, 7)});  // larger than the writer's buffer
  items.push_back({"EMPTY", -6, {}});
  write_log(file.path(), items);

  LcmLogReader reader(file.path());
  LogEvent event;
  for (std::size_t i = 0; i < items.size(); ++i) {
    REQUIRE(reader.next(event) == Status::ok);
    CHECK(event.number == static_cast<std::int64_t>(i));
    REQUIRE(same(event, items[i]));
  }
  CHECK(reader.next(event) == Status::empty);
  CHECK(reader.next(event) == Status::empty);

  lcm_eventlog_t* theirs = lcm_eventlog_create(file.path().c_str(), "r");
  REQUIRE(theirs != nullptr);
  for (std::size_t i = 0; i < items.size(); ++i) {
    lcm_eventlog_event_t* read = lcm_eventlog_read_next_event(theirs);
    REQUIRE(read != nullptr);
    CHECK(read->eventnum == static_cast<std::int64_t>(i));
    CHECK(read->timestamp == items[i].time_us);
    CHECK(std::string(read->channel) == items[i].channel);
    const auto* data = static_cast<const std::uint8_t*>(read->data);
    CHECK(Bytes(data, data + read->datalen) == items[i].data);
    lcm_eventlog_free_event(read);
  }
  CHECK(lcm_eventlog_read_next_event(theirs) == nullptr);
  lcm_eventlog_destroy(theirs);
}

TEST_CASE("a log that liblcm writes is byte for byte the one that we write") {
  TempFile theirs_file("theirs.lcm");
  TempFile ours_file("twin.lcm");
  std::vector<Item> items = some_items(100, 2);
  lcm_eventlog_t* theirs = lcm_eventlog_create(theirs_file.path().c_str(), "w");
  REQUIRE(theirs != nullptr);
  for (Item& item : items) {
    lcm_eventlog_event_t event{};
    event.timestamp = item.time_us;
    event.channel = item.channel.data();
    event.channellen = static_cast<std::int32_t>(item.channel.size());
    event.data = item.data.data();
    event.datalen = static_cast<std::int32_t>(item.data.size());
    REQUIRE(lcm_eventlog_write_event(theirs, &event) == 0);
  }
  lcm_eventlog_destroy(theirs);
  write_log(ours_file.path(), items);
  CHECK(theirs_file.read() == ours_file.read());
}

TEST_CASE("a reader says in one line why it cannot open a file") {
  const auto reason = [](const std::string& path) -> std::string {
    try {
      LcmLogReader reader(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(reason("/nonexistent/log.lcm").find("/nonexistent/log.lcm: No such file") == 0);
  CHECK(reason("/tmp").find("not a regular file") != std::string::npos);
  TempFile text("text.csv");
  const std::string words = "time,x,y\n";
  text.write({reinterpret_cast<const std::uint8_t*>(words.data()), words.size()});
  CHECK(reason(text.path()).find("byte 0: is not an LCM event log (begins with 74 69 6d 65") !=
        std::string::npos);
  TempFile empty("empty.lcm");
  empty.write({});
  CHECK(reason(empty.path()).empty());
  LcmLogReader reader(empty.path());
  LogEvent event;
  CHECK(reader.next(event) == Status::empty);
}

TEST_CASE("names that no reader would take are refused before they are written") {
  TempFile file("names.lcm");
  LcmLogWriter writer(file.path());
  CHECK(writer.append("", 0, {}) == Status::malformed);
  CHECK(writer.append(std::string(64, 'x'), 0, {}) == Status::malformed);
  CHECK(writer.append(std::string_view("a\0b", 3), 0, {}) == Status::malformed);
  CHECK(writer.append(std::string(63, 'x'), 0, {}) == Status::ok);
  CHECK(writer.close() == Status::ok);
  CHECK(writer.close() == Status::ok);
  CHECK(writer.append("A", 0, {}) == Status::disconnected);
  CHECK(writer.refused() == 1);
}

TEST_CASE("a full device is reported in one line and refuses what follows") {
  if (!std::filesystem::exists("/dev/full")) {
    WARN("skipped: no /dev/full here");
    return;
  }
  LcmLogWriter writer("/dev/full");
  CHECK(writer.append("A", 0, Bytes(10)) == Status::ok);
  CHECK(writer.flush() == Status::full);
  CHECK(writer.append("A", 0, Bytes(10)) == Status::full);
  CHECK(writer.events() == 0);
  CHECK(writer.lost() == 1);
  CHECK(writer.refused() == 1);
  CHECK(writer.error().find("/dev/full: writing failed after byte 0: No space left on device") == 0);
  CHECK(writer.close() == Status::full);
}

TEST_CASE("when the disk fills up the file ends with its last complete event") {
  TempFile file("limit.lcm");
  const rlim_t limit = 10'000;
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  auto* const old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{limit, before.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  const std::vector<Item> items = some_items(200, 7);
  std::uint64_t safe = 0;
  std::uint64_t lost = 0;
  std::string error;
  for (const bool big : {false, true}) {
    LcmLogWriter writer(file.path(), 4096);
    std::uint64_t accepted = 0;
    if (big) REQUIRE(writer.append("SMALL", 0, Bytes(9'000)) == Status::ok);
    for (const Item& item : items) {
      if (writer.append(item.channel, item.time_us, big ? Bytes(20'000) : item.data) == Status::ok)
        ++accepted;
    }
    CHECK(writer.close() == Status::full);
    safe = writer.events();
    lost = writer.lost();
    error = writer.error();
    if (big) {
      CHECK(safe == 1);
    } else {
      CHECK(lost > 0);
      CHECK(safe == accepted - lost);
    }
    LcmLogReader reader(file.path());
    LogEvent event;
    while (reader.next(event) == Status::ok) {
      if (!big) REQUIRE(same(event, items[static_cast<std::size_t>(event.number)]));
    }
    CHECK(reader.next(event) == Status::empty);
    CHECK(reader.events() == safe);
    CHECK(reader.size_bytes() == writer.bytes());
    CHECK(error.find("free some space") != std::string::npos);
  }
  REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, old_handler);
}
