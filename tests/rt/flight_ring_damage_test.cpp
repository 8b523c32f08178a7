// SPDX-License-Identifier: BSD-3-Clause
// The flight ring when something goes wrong: what a killed process leaves behind, and what a damaged file
// is taken for.
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <stdexcept>

#include "tests/rt/flight_ring_rig.hpp"

namespace sortie::rt::posix {

using namespace test;

namespace {

template <class F>
std::string refusal(F call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

// Runs `work` in a child process and gives its wait status.
template <class Work, class Meanwhile>
int in_child(Work work, Meanwhile meanwhile) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  REQUIRE(child > 0);
  meanwhile(child);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return status;
}

}  // namespace

TEST_CASE("a process that is killed leaves every job up to its last") {
  const RingFolder folder;
  auto* shared = static_cast<std::atomic<std::uint32_t>*>(
      mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  REQUIRE(shared != MAP_FAILED);
  std::mt19937 random(4);
  std::uint32_t torn = 0;
  for (int round = 0; round < 25; ++round) {
    std::filesystem::remove(folder.file());
    shared->store(0);
    const int status = in_child(
        [&] {
          FlightRing ring(folder.file(), plan_of_two());
          for (std::uint32_t tick = 0;; ++tick) {
            ring.running(0)->store(2);
            ring.job(job_of(0, tick));
            shared->store(tick + 1);
            if (tick % 10 == 3) ring.job(job_of(1, tick / 10));
          }
        },
        [&](pid_t child) {
          while (shared->load() < 100) usleep(200);
          usleep(static_cast<useconds_t>(random() % 5000));
          kill(child, SIGKILL);
        });
    REQUIRE(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGKILL);
    const FlightReader reader(folder.file());
    const auto last = check_jobs(reader);
    // The job whose number was announced is there; the next one may be, or may be the one that was cut.
    const auto announced = static_cast<std::int64_t>(shared->load()) - 1;
    CHECK(last[0] >= announced);
    CHECK(last[0] <= announced + 1);
    CHECK(reader.damaged() == 0);
    CHECK(reader.torn() <= 1);
    CHECK(reader.running(0) == 1);
    CHECK_FALSE(reader.writer_lives());
    CHECK_FALSE(reader.ended());
    torn += reader.torn();
  }
  munmap(shared, 4096);
  INFO("jobs that were being written when the process died: " << torn);
}

TEST_CASE("a crash leaves the task that was running") {
  const RingFolder folder;
  const int status = in_child(
      [&] {
        signal(SIGSEGV, SIG_DFL);
        FlightRing ring(folder.file(), plan_of_two());
        ring.job(job_of(0, 0));
        ring.running(0)->store(0);
        ring.running(1)->store(1);
        raise(SIGSEGV);
      },
      [](pid_t) {});
  REQUIRE(WIFSIGNALED(status));
  const FlightReader reader(folder.file());
  CHECK(reader.running(0) == -1);
  CHECK(reader.running(1) == 0);
  CHECK(reader.jobs().size() == 1);
}

TEST_CASE("a job that is half written is recognised at every word") {
  const RingFolder folder;
  { FlightRing(folder.file(), plan_of_two()).job(job_of(0, 0)); }
  const std::string before = bytes_of(folder.file());
  const FlightHeader header = FlightReader(folder.file()).header();
  {
    std::filesystem::remove(folder.file());
    FlightRing ring(folder.file(), plan_of_two());
    for (std::uint64_t i = 0; i <= header.group[0].jobs.slots; ++i) ring.job(job_of(0, i));  // slot 0 twice
  }
  const std::string after = bytes_of(folder.file());
  const auto entry = static_cast<std::size_t>(header.group[0].jobs.offset);
  for (std::uint32_t cut = 1; cut <= kJobWords; ++cut) {
    // The order in which the words are stored: sequence, then the others, then the sequence again.
    std::string bytes = after;
    std::memcpy(bytes.data() + entry, before.data() + entry, kJobWords * 4);
    std::memcpy(bytes.data() + entry, after.data() + entry, cut * 4);
    const auto writing = static_cast<std::uint32_t>(2 * header.group[0].jobs.slots + 1);
    std::memcpy(bytes.data() + entry, &writing, 4);
    write_bytes(folder.file(), bytes);
    const FlightReader reader(folder.file());
    CHECK(reader.torn() == 1);
    CHECK(reader.damaged() == 0);
    CHECK(check_jobs(reader)[0] == static_cast<std::int64_t>(header.group[0].jobs.slots) - 1);
  }
}

TEST_CASE("a flight ring that is cut off at any byte gives a clear error") {
  const RingFolder folder;
  { FlightRing(folder.file(), plan_of_two(16)).job(job_of(0, 0)); }
  const std::string whole = bytes_of(folder.file());
  std::mt19937 random(8);
  for (int round = 0; round < 200; ++round) {
    const std::size_t size = round < 20 ? static_cast<std::size_t>(round) : random() % whole.size();
    INFO(size);
    write_bytes(folder.file("cut.ring"), whole.substr(0, size));
    const std::string why = refusal([&] { const FlightReader reader(folder.file("cut.ring")); });
    CHECK(why.find("cut.ring: ") != std::string::npos);
    CHECK(why.find(size < 8 ? "is no flight ring" : std::to_string(size)) != std::string::npos);
    CHECK(why.find('\n') == std::string::npos);
  }
  CHECK(refusal([&] { const FlightReader reader(folder.file("absent.ring")); }).find("No such file") !=
        std::string::npos);
}

TEST_CASE("a byte that is changed anywhere is found or does not matter") {
  const RingFolder folder;
  {
    FlightRing ring(folder.file(), plan_of_two(16));
    for (std::uint64_t i = 0; i < 40; ++i) ring.job(job_of(0, i));
    ring.track(0).add(0, 1, 2);
    ring.event(5, 6, "something");
  }
  const std::string whole = bytes_of(folder.file());
  const FlightReader good(folder.file());
  const FlightHeader& header = good.header();
  const auto jobs_at = static_cast<std::size_t>(header.group[0].jobs.offset);
  const std::size_t jobs_bytes = std::size_t{header.group[0].jobs.slots} * kJobWords * 4;
  const std::size_t jobs_end = jobs_at + jobs_bytes;
  std::mt19937 random(15);
  for (int round = 0; round < 600; ++round) {
    std::size_t at = random() % whole.size();
    if (round % 3 == 0) at = random() % sizeof(FlightHeader);
    if (round % 3 == 1) at = jobs_at + random() % jobs_bytes;
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
    INFO("byte " << at);
    write_bytes(folder.file("bad.ring"), bytes);
    const std::string why = refusal([&] {
      const FlightReader reader(folder.file("bad.ring"));
      CHECK(at >= sizeof(FlightHeader));
      if (at >= jobs_at && at < jobs_end) {
        CHECK(reader.torn() + reader.damaged() == 1);
        CHECK(reader.jobs().size() == good.jobs().size() - 1);
      }
      for (const FlightJob& job : reader.jobs()) REQUIRE(equals(job, job_of(0, job.tick)));
    });
    if (at < sizeof(FlightHeader)) CHECK_FALSE(why.empty());
  }
}

TEST_CASE("a job of a time that no run has is damage, whatever its check says") {
  const RingFolder folder;
  {
    FlightRing ring(folder.file(), plan_of_two(16));
    ring.job(job_of(0, 1));
    JobRecord odd = job_of(0, 2);
    odd.tick = std::uint64_t{1} << 62;  // times 1 ms: beyond all clocks
    ring.job(odd);
    odd = job_of(0, 3);
    odd.started_ns = INT64_MIN + 5;
    ring.job(odd);
    ring.job(job_of(0, 4));
  }
  const FlightReader reader(folder.file());
  CHECK(reader.damaged() == 2);
  REQUIRE(reader.jobs().size() == 2);
  CHECK(equals(reader.jobs()[0], job_of(0, 1)));
  CHECK(equals(reader.jobs()[1], job_of(0, 4)));
}

TEST_CASE("an older ring is kept if its run did not end and replaced if it did") {
  const RingFolder folder;
  { FlightRing(folder.file(), plan_of_two()).job(job_of(0, 0)); }
  {
    FlightRing ring(folder.file(), plan_of_two());
    REQUIRE_FALSE(ring.warnings().empty());
    CHECK(ring.warnings().front().find("flight.ring.previous") != std::string::npos);
    CHECK(FlightReader(folder.file("flight.ring.previous")).jobs().size() == 1);
    CHECK(refusal([&] { const FlightRing second(folder.file(), plan_of_two()); }).find("still going") !=
          std::string::npos);
    ring.finish(123);
  }
  CHECK(FlightReader(folder.file()).ended());
  std::filesystem::remove(folder.file("flight.ring.previous"));
  {
    const FlightRing ring(folder.file(), plan_of_two());
    for (const std::string& warning : ring.warnings()) CHECK(warning.find("previous") == std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder.file("flight.ring.previous")));
}

TEST_CASE("a flight ring is never written over or through something else") {
  const RingFolder folder;
  write_bytes(folder.file("letter"), "Dear mother");
  CHECK(refusal([&] {
          const FlightRing ring(folder.file("letter"), plan_of_two());
        }).find("no flight ring") != std::string::npos);
  CHECK(bytes_of(folder.file("letter")) == "Dear mother");
  std::filesystem::create_symlink(folder.file("letter"), folder.file("link"));
  CHECK_FALSE(refusal([&] { const FlightRing ring(folder.file("link"), plan_of_two()); }).empty());
  CHECK_FALSE(refusal([&] { const FlightRing ring(folder.path, plan_of_two()); }).empty());
  CHECK_FALSE(refusal([&] { const FlightRing ring(folder.file("no/such/folder"), plan_of_two()); }).empty());
  CHECK(bytes_of(folder.file("letter")) == "Dear mother");
  const int status = in_child(
      [&] {
        signal(SIGXFSZ, SIG_IGN);
        const rlimit small{100'000, 100'000};
        setrlimit(RLIMIT_FSIZE, &small);
        const std::string why = refusal([&] { const FlightRing ring(folder.file("big"), plan_of_two()); });
        _exit(why.find("no room for") != std::string::npos && access(folder.file("big").c_str(), F_OK) != 0
                  ? 7
                  : 8);
      },
      [](pid_t) {});
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 7));
}

}  // namespace sortie::rt::posix
