// SPDX-License-Identifier: BSD-3-Clause
// The beginning of a flight ring: a start that dies or is refused takes nothing away and is in nobody's way.
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "tests/rt/emulated.hpp"
#include "tests/rt/flight_ring_rig.hpp"

namespace sortie::rt::posix {

using namespace test;

namespace {

FlightPlan waiting_plan() {
  FlightPlan plan = plan_of_two(16);
  plan.waits = true;
  return plan;
}

std::size_t jobs_in(const std::string& path) { return FlightReader(path).jobs().size(); }

}  // namespace

TEST_CASE("a ring that waits leaves the one before in its place until it is told") {
  const RingFolder folder;
  const std::string kept = folder.file("flight.ring.previous");
  { FlightRing(folder.file(), plan_of_two(16)).job(job_of(0, 0)); }
  { const FlightRing refused(folder.file(), waiting_plan()); }
  CHECK(jobs_in(folder.file()) == 1);
  CHECK_FALSE(std::filesystem::exists(kept));
  CHECK_FALSE(std::filesystem::exists(folder.file("flight.ring.part")));
  FlightRing ring(folder.file(), waiting_plan());
  ring.job(job_of(0, 0));
  ring.job(job_of(0, 1));
  CHECK(jobs_in(folder.file()) == 1);
  CHECK(ring.take_place().empty());
  CHECK(ring.take_place().empty());
  CHECK(jobs_in(folder.file()) == 2);
  CHECK(jobs_in(kept) == 1);
  CHECK(FlightReader(folder.file()).writer_lives());
}

TEST_CASE("whatever is left of a ring's making, the next one is made") {
  const RingFolder folder;
  { const FlightRing ring(folder.file("whole.ring"), plan_of_two(16)); }
  const std::string whole = bytes_of(folder.file("whole.ring"));
  std::mt19937 random(23);
  for (int round = 0; round < 60; ++round) {
    // Space is taken at once and is zero; the header comes last, from its first byte on.
    std::string half = round % 3 == 0 ? std::string() : std::string(whole.size(), '\0');
    if (round % 3 == 2) {
      const std::size_t header = 8 + random() % (sizeof(FlightHeader) - 7);
      half.replace(0, header, whole, 0, header);
    }
    INFO(round);
    // A program before this one made the file in its place.
    write_bytes(folder.file(round % 2 == 0 ? "flight.ring.part" : "flight.ring"), half);
    FlightRing ring(folder.file(), waiting_plan());
    ring.job(job_of(0, 0));
    CHECK(ring.take_place().empty());
    CHECK(jobs_in(folder.file()) == 1);
    ring.finish(1);
  }
}

TEST_CASE("a ring that died with a job before it took its place is kept") {
  const RingFolder folder;
  { FlightRing(folder.file("flight.ring.part"), plan_of_two(16)).job(job_of(0, 0)); }
  {
    FlightRing ring(folder.file(), waiting_plan());
    REQUIRE_FALSE(ring.warnings().empty());
    CHECK(ring.warnings().front().find("flight.ring.previous") != std::string::npos);
    CHECK(ring.take_place().empty());
  }
  CHECK(jobs_in(folder.file("flight.ring.previous")) == 1);
  std::filesystem::remove(folder.file("flight.ring.previous"));
  { const FlightRing without_a_job(folder.file("other.ring.part"), plan_of_two(16)); }
  {
    FlightRing ring(folder.file("other.ring"), waiting_plan());
    CHECK(ring.take_place().empty());
  }
  CHECK_FALSE(std::filesystem::exists(folder.file("other.ring.previous")));
}

TEST_CASE("a pipe or a link where a ring may have died is let be, and keeps nobody waiting") {
  const RingFolder folder;
  REQUIRE(mkfifo(folder.file("flight.ring.part").c_str(), 0600) == 0);
  CHECK_FALSE(FlightReader::was_left(folder.file("flight.ring.part")));
  std::filesystem::remove(folder.file("flight.ring.part"));
  { FlightRing(folder.file("elsewhere.part"), plan_of_two(16)).job(job_of(0, 0)); }
  REQUIRE(FlightReader::was_left(folder.file("elsewhere.part")));
  std::filesystem::create_symlink(folder.file("elsewhere.part"), folder.file("flight.ring.part"));
  CHECK_FALSE(FlightReader::was_left(folder.file("flight.ring.part")));
}

// Where every access is watched the watcher itself has taken the address space.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("a ring whose file cannot be mapped leaves the one before and nothing else") {
  if (emulated()) return;  // a limit of the address space would be the emulator's
  const RingFolder folder;
  { FlightRing(folder.file(), plan_of_two(16)).job(job_of(0, 0)); }
  const pid_t child = fork();
  if (child == 0) {
    FlightPlan plan = plan_of_two(1'000'000);  // 100 MB and more
    plan.waits = true;
    const rlimit small{96u << 20, 96u << 20};
    setrlimit(RLIMIT_AS, &small);
    int code = 8;
    try {
      const FlightRing ring(folder.file(), plan);
    } catch (const std::runtime_error& error) {
      code = std::string(error.what()).find("annot allocate memory") != std::string::npos ? 7 : 9;
    }
    _exit(code);
  }
  REQUIRE(child > 0);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 7);
  CHECK(jobs_in(folder.file()) == 1);
  CHECK_FALSE(std::filesystem::exists(folder.file("flight.ring.part")));
  FlightRing ring(folder.file(), waiting_plan());
  CHECK(ring.take_place().empty());
}
#endif

}  // namespace sortie::rt::posix
