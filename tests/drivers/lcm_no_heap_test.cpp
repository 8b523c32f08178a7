// SPDX-License-Identifier: BSD-3-Clause
// What the runtime calls while it runs takes no memory: codecs, publishing, the log's writer and cursor, the
// receiver.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_telemetry.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/drivers/own_network.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Bytes = std::vector<std::uint8_t>;

bool trap_works() {
  rt::posix::HeapTrapScope scope;
  void* volatile block = std::malloc(1);  // volatile: an unused block would be optimised away
  std::free(block);
  return scope.calls() != 0;
}

}  // namespace

TEST_CASE("codecs of samples and records take no memory") {
  if (!trap_works()) {
    WARN("skipped: a sanitizer owns the heap in this build");
    return;
  }
  Bytes bytes(8192);
  std::vector<rt::ScanPoint> points(100);
  const ExecStats tasks{3, std::vector<TaskTiming>(5)};
  const std::vector<NamedValue> values(13, {"a value with a long name", 1.5});
  std::size_t size = 0;
  std::int64_t seq = 0;
  std::uint64_t calls = 0;
  bool good = true;
  {
    const rt::posix::HeapTrapScope scope;
    rt::ImuSample imu;
    good = encode(imu, 1, bytes, size) == Status::ok && good;
    good = decode(std::span(bytes).first(size), imu, seq) == Status::ok && good;
    rt::PointScan scan;
    scan.header.points = 100;
    scan.points = points.data();
    good = encode(scan, 2, bytes, size) == Status::ok && good;
    good = decode(std::span(bytes).first(size), scan.header, points, seq) == Status::ok && good;
    rt::JobRecord record{};
    record.streams = rt::kMaxStreamsPerGroup;
    record.tasks = rt::kMaxTasksPerGroup;
    good = encode(record, bytes, size) == Status::ok && good;
    good = decode(std::span(bytes).first(size), record) == Status::ok && good;
    good = encode(tasks, bytes, size) == Status::ok && good;
    good = encode(FieldsView{4, "attitude", values}, bytes, size) == Status::ok && good;
    calls = scope.calls();
  }
  CHECK(good);
  CHECK(calls == 0);
}

TEST_CASE("publishing takes no memory, whether there is room or not") {
  if (!trap_works()) {
    WARN("skipped: a sanitizer owns the heap in this build");
    return;
  }
  LcmPublisher publisher({"memq://", 16, 256});
  REQUIRE(publisher.problem().empty());
  const Bytes message(200);
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 1000; ++i) static_cast<void>(publisher.publish("A", message));
    static_cast<void>(publisher.publish("A", std::span(message).first(0)));
    static_cast<void>(publisher.publish("", message));
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(publisher.counters().dropped > 0);
}

TEST_CASE("writing and walking a log takes no memory") {
  if (!trap_works()) {
    WARN("skipped: a sanitizer owns the heap in this build");
    return;
  }
  const auto path =
      std::filesystem::temp_directory_path() / ("sortie_heap_" + std::to_string(getpid()) + ".lcm");
  const Bytes message(3000, 0xED);
  std::uint64_t calls = 0;
  {
    LcmLogWriter writer(path.string(), 8192);
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 100; ++i) static_cast<void>(writer.append("A", i, message));
    static_cast<void>(writer.close());
    calls = scope.calls();
  }
  CHECK(calls == 0);
  std::filesystem::resize_file(path, 50'000);
  LcmLogReader reader(path.string());
  {
    const rt::posix::HeapTrapScope scope;
    LogEvent event;
    while (reader.next(event) == Status::ok) {
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(reader.events() == 16);
  CHECK(reader.problem().event == 16);
  std::filesystem::remove(path);
}

TEST_CASE("receiving takes no memory") {
  if (!trap_works()) {
    WARN("skipped: a sanitizer owns the heap in this build");
    return;
  }
  if (const std::string why = test::enter_own_network(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  LcmReceiver receiver("udpm://239.255.76.67:7669");
  LcmPublisher publisher({"udpm://239.255.76.67:7669?ttl=0", 16, 256});
  REQUIRE(publisher.active());
  const Bytes message(200);
  for (int i = 0; i < 10; ++i) REQUIRE(publisher.publish("A", message) == Status::ok);
  int received = 0;
  std::uint64_t calls = 0;
  {
    const rt::posix::HeapTrapScope scope;
    ReceivedMessage next;
    while (received < 10 && receiver.receive(next, 5000) == Status::ok) ++received;
    calls = scope.calls();
  }
  CHECK(received == 10);
  CHECK(calls == 0);
}
