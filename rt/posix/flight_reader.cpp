// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/flight_reader.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>

#include "rt/digest.hpp"
#include "rt/posix/file_place.hpp"
#include "rt/stamp_gate.hpp"

namespace sortie::rt::posix {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

constexpr std::uint64_t kFarthest = std::uint64_t{1} << 61;  // ns from tick 0, as is_far() has it

template <std::size_t N>
bool ends(const char (&text)[N]) {
  return std::memchr(text, '\0', N) != nullptr;
}

std::uint64_t word64(const std::uint32_t* words) { return words[0] | std::uint64_t{words[1]} << 32; }

bool fits(const FlightPlace& place, std::uint32_t words, std::uint64_t bytes) {
  return std::has_single_bit(place.slots) && place.offset % 4 == 0 && place.offset >= kFlightHeaderBytes &&
         place.offset <= bytes && std::uint64_t{place.slots} * words * 4 <= bytes - place.offset;
}

/// A header whose check is right may still be of a program that writes nonsense: nothing here trusts it.
bool is_sound(const FlightHeader& header) {
  const std::uint64_t bytes = header.file_bytes;
  bool sound = header.groups <= kMaxGroups && header.tracks <= kMaxFlightTracks && header.base_tick_ns > 0 &&
               !is_far(header.epoch_ns) && !is_far(header.start_ns) &&
               !is_far(header.utc_minus_monotonic_ns) && header.span_names <= kMaxSpanNames &&
               ends(header.boot_id) && ends(header.scene) && ends(header.vehicle) &&
               ends(header.version_text) && fits(header.events, kEventWords, bytes);
  for (std::uint32_t i = 0; sound && i < header.groups; ++i) {
    const FlightGroup& group = header.group[i];
    sound = ends(group.name) && group.period_ticks > 0 && group.tasks <= kMaxTasksPerGroup &&
            fits(group.jobs, kJobWords, bytes);
    for (const auto& task : group.task) sound = sound && ends(task);
  }
  for (std::uint32_t i = 0; sound && i < header.tracks; ++i)
    sound = ends(header.track[i].name) && fits(header.track[i].spans, kSpanWords, bytes);
  for (const auto& name : header.span_name) sound = sound && ends(name);
  return sound;
}

// The beginning of an ordinary file of this user. Where a ring lies others may put a pipe, which would keep
// who opens it waiting, a link, or a ring of their own.
bool read_own(const std::string& path, std::span<char> bytes) noexcept {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return false;
  struct stat found {};
  const bool own = fstat(file, &found) == 0 && S_ISREG(found.st_mode) && found.st_uid == geteuid();
  const bool whole = own && pread(file, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
  close(file);
  return whole;
}

// The state of a ring with a whole header of this format.
bool read_state(const std::string& path, FlightState& out) noexcept {
  try {
    std::vector<char> bytes(kFlightHeaderBytes);
    if (!read_own(path, bytes)) return false;
    const auto header = std::make_unique<FlightHeader>();
    std::memcpy(header.get(), bytes.data(), sizeof(FlightHeader));
    std::memcpy(&out, bytes.data() + kFlightStateOffset, sizeof(out));
    return std::memcmp(header->magic, kFlightMagic, sizeof(kFlightMagic)) == 0 &&
           header->version == kFlightVersion && flight_header_check(*header) == header->check;
  } catch (...) {
    return false;
  }
}

}  // namespace

std::uint64_t flight_header_check(const FlightHeader& header) {
  FlightHeader copy = header;
  copy.check = 0;
  return digest_bytes(&copy, sizeof(copy));
}

bool FlightReader::is_ring(const std::string& path) noexcept {
  try {
    std::ifstream in(path, std::ios::binary);
    char magic[sizeof(kFlightMagic)]{};
    in.read(magic, sizeof(magic));
    return in && std::memcmp(magic, kFlightMagic, sizeof(magic)) == 0;
  } catch (...) {
    return false;
  }
}

bool FlightReader::is_blank(const std::string& path) noexcept {
  try {
    std::ifstream in(path, std::ios::binary);
    if (!in) return false;
    std::vector<char> piece(1u << 16);
    do {
      in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
      const auto end = piece.begin() + in.gcount();
      if (std::any_of(piece.begin(), end, [](char byte) { return byte != '\0'; })) return false;
    } while (in);
    return in.eof();
  } catch (...) {
    return false;
  }
}

bool FlightReader::has_ended(const std::string& path) noexcept {
  FlightState state;
  return read_state(path, state) && state.ended == 1;
}

bool FlightReader::was_left(const std::string& path) noexcept {
  FlightState state;
  return read_state(path, state) && state.ended != 1 && !is_being_written(path);
}

FlightReader::FlightReader(const std::string& path) : header_(std::make_unique<FlightHeader>()) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, std::string(std::strerror(errno)) + "; give the path of a flight ring");
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::vector<char> bytes(error ? 0 : static_cast<std::size_t>(size));
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  take_header(path, bytes);
  writer_lives_ = is_being_written(path);
  std::memcpy(&state_, bytes.data() + kFlightStateOffset, sizeof(state_));
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  read_jobs(words);
  read_spans(words);
  read_ring(words, header_->events, kEventWords, [&](const std::uint32_t* w) {
    const std::size_t length = std::min<std::size_t>(w[4], kEventText);
    events_.push_back({static_cast<Nanoseconds>(word64(w)), word64(w + 2),
                       std::string(reinterpret_cast<const char*>(w + 5), length)});
  });
  std::ranges::stable_sort(jobs_, {}, &FlightJob::tick);
  std::ranges::stable_sort(spans_, {}, &FlightSpan::begin_ns);
  std::ranges::stable_sort(events_, {}, &FlightEvent::time_ns);
}

// Refuses what is no whole flight ring of this format, with the cure.
void FlightReader::take_header(const std::string& path, const std::vector<char>& bytes) {
  if (bytes.size() < sizeof(kFlightMagic) ||
      std::memcmp(bytes.data(), kFlightMagic, sizeof(kFlightMagic)) != 0)
    fail(path, "is no flight ring; `sortie run --flight-ring FILE` writes one");
  if (bytes.size() < kFlightHeaderBytes) {
    fail(path, "is cut off at byte " + std::to_string(bytes.size()) + ", in its header of " +
                   std::to_string(kFlightHeaderBytes) + " bytes; copy it again");
  }
  std::memcpy(header_.get(), bytes.data(), sizeof(FlightHeader));
  const FlightHeader& header = *header_;
  if (header.version != kFlightVersion || header.header_bytes != kFlightHeaderBytes) {
    fail(path, "is a flight ring of format " + std::to_string(header.version) +
                   ", and this program reads format " + std::to_string(kFlightVersion) +
                   "; use the program that wrote it");
  }
  if (flight_header_check(header) != header.check || !is_sound(header))
    fail(path,
         "the header (bytes 0 to " + std::to_string(sizeof(FlightHeader)) + ") is damaged; copy it again");
  if (bytes.size() != header.file_bytes) {
    fail(path, "has " + std::to_string(bytes.size()) + " bytes of " + std::to_string(header.file_bytes) +
                   "; copy it again");
  }
}

void FlightReader::read_jobs(const std::vector<std::uint32_t>& words) {
  const FlightHeader& header = *header_;
  for (std::uint32_t group = 0; group < header.groups; ++group) {
    read_ring(words, header.group[group].jobs, kJobWords, [&](const std::uint32_t* w) {
      FlightJob job;
      job.group = group;
      job.tick = word64(w);
      job.started_ns = static_cast<Nanoseconds>(word64(w + 2));
      // The sum of such times never overflows; what no run can have is damage.
      if (is_far(job.started_ns) || job.tick > kFarthest / static_cast<std::uint64_t>(header.base_tick_ns)) {
        ++damaged_;
        return;
      }
      job.verdict = static_cast<Verdict>(w[4] & 0xffu);
      job.tasks = std::min((w[4] >> 8) & 0xffu, kMaxTasksPerGroup);
      job.level = static_cast<std::uint8_t>(w[4] >> 16);
      job.shed = static_cast<std::uint16_t>(w[5]);
      job.cut = static_cast<std::uint16_t>(w[5] >> 16);
      std::copy_n(w + 6, kMaxTasksPerGroup, job.duration_ns);
      std::copy_n(w + 6 + kMaxTasksPerGroup, kMaxTasksPerGroup, job.units);
      jobs_.push_back(job);
    });
  }
}

void FlightReader::read_spans(const std::vector<std::uint32_t>& words) {
  const FlightHeader& header = *header_;
  for (std::uint32_t track = 0; track < header.tracks; ++track) {
    read_ring(words, header.track[track].spans, kSpanWords, [&](const std::uint32_t* w) {
      if (is_far(static_cast<Nanoseconds>(word64(w)))) {
        ++damaged_;
        return;
      }
      const char* name = w[3] < header.span_names ? header.span_name[w[3]] : "?";
      spans_.push_back({track, name, static_cast<Nanoseconds>(word64(w)) - header.start_ns, w[2]});
    });
  }
}

template <class Take>
void FlightReader::read_ring(const std::vector<std::uint32_t>& words, const FlightPlace& place,
                             std::uint32_t count, Take take) {
  for (std::uint32_t slot = 0; slot < place.slots; ++slot) {
    const std::uint32_t* entry = words.data() + place.offset / 4 + std::size_t{slot} * count;
    const std::uint32_t sequence = entry[0];
    if (std::all_of(entry, entry + count, [](std::uint32_t word) { return word == 0; })) continue;
    const bool placed = (((sequence - 1) / 2) & (place.slots - 1)) == slot;
    if (sequence % 2 == 1 && placed) {
      ++torn_;
    } else if (!placed || entry[1] != flight_check(sequence, entry + 2, count - 2)) {
      ++damaged_;
    } else {
      take(entry + 2);
    }
  }
}

int FlightReader::running(std::uint32_t group) const {
  const std::uint32_t task = group < header_->groups ? state_.running[group] : 0;
  return task == 0 || task > header_->group[group].tasks ? -1 : static_cast<int>(task) - 1;
}

}  // namespace sortie::rt::posix
