// SPDX-License-Identifier: BSD-3-Clause
// Rings of two made-up groups whose records a reader can judge alone.
#pragma once

#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "rt/posix/flight_reader.hpp"
#include "rt/posix/flight_ring.hpp"

namespace sortie::rt::posix::test {

/// A folder on a memory file system where there is one.
struct RingFolder {
  std::string path;
  RingFolder() : path(access("/dev/shm", W_OK) == 0 ? "/dev/shm/sortie-XXXXXX" : "/tmp/sortie-XXXXXX") {
    REQUIRE(mkdtemp(path.data()) != nullptr);
  }
  ~RingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  RingFolder(const RingFolder&) = delete;
  RingFolder& operator=(const RingFolder&) = delete;
  std::string file(const char* name = "flight.ring") const { return path + "/" + name; }
};

/// Two groups, and room for little.
inline FlightPlan plan_of_two(std::uint32_t ticks = 1000) {
  FlightPlan plan;
  FlightHeader& header = plan.header;
  copy_text(header.scene, "test");
  copy_text(header.vehicle, "cart");
  header.scene_hash = 77;
  header.base_tick_ns = 1'000'000;
  header.start_ns = 5'000'000'000;
  header.groups = 2;
  header.group[0] = {"fast", 1, 0, 1, 2, 2, 0, {50, 60}, {"imu", "attitude"}, {}};
  header.group[1] = {"slow", 10, 3, 10, -1, 1, 0, {900}, {"map"}, {}};
  plan.more_tracks = {"devices"};
  plan.ticks = ticks;
  plan.spans = 64;
  plan.events = 16;
  return plan;
}

/// Everything in a record follows from its group and number, so that a reader can judge it alone.
inline JobRecord job_of(std::uint16_t group, std::uint64_t number) {
  JobRecord record;
  record.group = group;
  record.job = number;
  record.tick = group == 0 ? number : number * 10 + 3;
  record.verdict = number % 7 == 0 ? Verdict::missed : Verdict::done;
  record.tasks = group == 0 ? 2 : 1;
  record.level = static_cast<std::uint8_t>(number % 5);
  record.shed = static_cast<std::uint16_t>(number % 3);
  record.cut = static_cast<std::uint16_t>(number * 31);
  record.started_ns = static_cast<Nanoseconds>(record.tick * 1'000'000 + number % 1000) - 500;
  for (std::uint32_t i = 0; i < record.tasks; ++i) {
    record.duration_ns[i] = static_cast<std::uint32_t>(number * 2654435761u + i);
    record.units[i] = static_cast<std::uint32_t>(number) ^ (i << 20);
  }
  return record;
}

/// A job as it was recorded.
inline bool equals(const FlightJob& job, const JobRecord& record) {
  bool same = job.group == record.group && job.tick == record.tick && job.started_ns == record.started_ns &&
              job.verdict == record.verdict && job.level == record.level && job.shed == record.shed &&
              job.cut == record.cut && job.tasks == record.tasks;
  for (std::uint32_t i = 0; i < kMaxTasksPerGroup; ++i) {
    const bool used = i < record.tasks;
    same = same && job.duration_ns[i] == (used ? record.duration_ns[i] : 0) &&
           job.units[i] == (used ? record.units[i] : 0);
  }
  return same;
}

/// Every job is as it was written, without a hole; gives the last job number of each group, or -1.
inline std::array<std::int64_t, 2> check_jobs(const FlightReader& reader) {
  std::array<std::int64_t, 2> last{-1, -1};
  for (const FlightJob& job : reader.jobs()) {
    REQUIRE(job.group < 2);
    const auto number = static_cast<std::int64_t>(job.group == 0 ? job.tick : (job.tick - 3) / 10);
    REQUIRE(equals(job, job_of(static_cast<std::uint16_t>(job.group), static_cast<std::uint64_t>(number))));
    if (last[job.group] >= 0) REQUIRE(number == last[job.group] + 1);
    last[job.group] = number;
  }
  return last;
}

/// A file as a whole.
inline std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace sortie::rt::posix::test
