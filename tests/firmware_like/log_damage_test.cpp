// SPDX-License-Identifier: BSD-3-Clause
// What is left of a log after a full disk, a power cut or a bad block: its good part replays, the rest is
// told, and nothing crashes.
#include <catch2/catch.hpp>
#include <random>

#include "drivers/channels.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/full_disk.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// Half a second of ugv_hall: some 1,500 events.
struct Short {
  TempFolder folder;
  std::string log = folder.file("short.lcm");
  LiveRunOutcome run = run_hall(0.5, log, true);
  std::vector<std::uint8_t> bytes = read(log);
  std::vector<std::uint64_t> edges;  // where events begin

  Short() {
    drivers::LcmLogReader reader(log);
    drivers::LogEvent event;
    while (reader.next(event) == Status::ok) edges.push_back(event.offset);
  }
  static std::vector<std::uint8_t> read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};
const Short& short_log() {
  static const Short recorded;
  return recorded;
}

std::string write(const TempFolder& folder, const std::vector<std::uint8_t>& bytes) {
  return folder.write("hurt.lcm", std::string(bytes.begin(), bytes.end()));
}

}  // namespace

TEST_CASE("a disk that is full leaves a log whose good part replays and that says what is missing") {
  const TempFolder folder;
  const std::string whole = folder.file("whole.lcm");
  const LiveRunOutcome run = run_hall(1.5, whole);
  const std::uint64_t size = std::filesystem::file_size(whole);
  for (const double share : {0.1, 0.4, 0.75, 0.999}) {
    const auto room = static_cast<std::uint64_t>(share * static_cast<double>(size));
    INFO("room for " << room << " of " << size << " bytes");
    const std::string path = folder.file("full.lcm");
    LiveRunOutcome cut;
    {
      const FullDisk disk(room);
      if (!disk.works()) {
        WARN("skipped: no limit on file sizes here");
        return;
      }
      cut = run_hall(1.5, path);
    }
    // The run itself goes on to its end, and says what happened to its log.
    CHECK(cut.results.digest == run.results.digest);
    CHECK(mentions(cut.results.warnings, "writing failed"));
    CHECK(std::filesystem::file_size(path) <= room);
    const LogFile log(path);
    CHECK(log.damage().empty());
    CHECK(mentions(log.problems(), "GAP from tick"));
    CHECK(mentions(log.problems(), "the disk was full"));
    const ReplayOutcome outcome = replay(log, own_vehicles(), {});
    CHECK(complaint_of(outcome) == "");
    CHECK(outcome.recorded.jobs > 0);
    CHECK(outcome.results.ticks <= log.whole_until());
    CHECK(outcome.results.ticks + 150 >= log.whole_until());
    CHECK(counter(outcome, "skipped_releases") == 0);  // simulated time leaves nothing out
  }
}

TEST_CASE("a device that takes nothing stops no run") {
  if (!std::filesystem::exists("/dev/full")) {
    WARN("skipped: no /dev/full");
    return;
  }
  const LiveRunOutcome run = run_hall(0.2, "/dev/full");
  CHECK(mentions(run.results.warnings, "writing failed"));
  CHECK(run.results.counters.at("jobs") > 100);
}

TEST_CASE("a log cut at any byte of its last events replays what is complete", "[heavy]") {
  const TempFolder folder;
  const auto& edges = short_log().edges;
  const std::uint64_t size = short_log().bytes.size();
  const std::uint64_t first = edges[edges.size() - 4];
  for (std::uint64_t cut = first; cut < size; ++cut) {
    INFO("cut at byte " << cut << " of " << size);
    const std::string path = folder.file("cut.lcm");
    cut_file(short_log().log, path, cut);
    const LogFile log(path);
    const bool at_edge = std::find(edges.begin(), edges.end(), cut) != edges.end();
    CHECK(log.damage().empty() == at_edge);
    if (at_edge || cut % 37 == 0) CHECK(complaint_of(replay(log, own_vehicles(), {})) == "");
  }
}

TEST_CASE("a tail of zeros as a power cut leaves it is told and the part before it replays") {
  const TempFolder folder;
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 12; ++round) {
    auto bytes = short_log().bytes;
    // Whole pages, as a file system loses them.
    const std::size_t from = (bytes.size() / 3 + random() % (bytes.size() / 2)) / 4096 * 4096;
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.end(), std::uint8_t{0});
    INFO("zeros from byte " << from << " of " << bytes.size());
    const LogFile log(write(folder, bytes));
    const ReplayOutcome outcome = replay(log, own_vehicles(), {});
    CHECK(log.damage().find("byte ") != std::string::npos);
    CHECK_FALSE(outcome.damage.empty());
    // The event in which the zeros begin may be complete by its length: then its contents are refused or
    // differ.
    if (outcome.results.counters.at("samples_damaged") == 0 && !outcome.divergence)
      CHECK(complaint_of(outcome) == "");
    if (outcome.divergence) {
      CHECK(outcome.divergence->tick + 400 > outcome.results.ticks);
    }
    CHECK(outcome.recorded.jobs > 50);
  }
}

TEST_CASE("a block of garbage anywhere in a log is survived and either told or harmless") {
  const TempFolder folder;
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  int told = 0;
  for (int round = 0; round < 30; ++round) {
    auto bytes = short_log().bytes;
    const std::size_t length = 1 + random() % 4096;
    const std::size_t from = random() % (bytes.size() - length);
    for (std::size_t i = from; i < from + length; ++i) bytes[i] = static_cast<std::uint8_t>(random());
    INFO("garbage in bytes " << from << " to " << from + length << " of " << bytes.size());
    try {
      const LogFile log(write(folder, bytes));
      const ReplayOutcome outcome = replay(log, own_vehicles(), {});
      const auto& counters = outcome.results.counters;
      const bool is_told = !outcome.damage.empty() || outcome.divergence.has_value() || !outcome.comparable ||
                           counters.at("samples_damaged") + counters.at("samples_missing") != 0;
      told += is_told ? 1 : 0;
      if (!is_told) CHECK(outcome.results.digest == hex(outcome.recorded.all));
    } catch (const InputError& error) {  // header or first jobs: nothing is left to replay
      CHECK(std::string(error.what()).find("lcm") != std::string::npos);
      ++told;
    } catch (const ProfileError&) {  // the profile in the header
      ++told;
    }
  }
  CHECK(told > 15);
}
