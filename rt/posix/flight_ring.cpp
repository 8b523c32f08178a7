// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/flight_ring.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "rt/posix/clock.hpp"
#include "rt/posix/flight_reader.hpp"

namespace sortie::rt::posix {
namespace {

std::uint32_t power_of_two(std::uint64_t at_least) {
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(std::bit_ceil(at_least), 16, 1u << 24));
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error(path + ": the flight ring cannot be kept here: " + why);
}

/// Gives `bytes` of the file, rounded up to cache lines, to a ring.
FlightPlace take(std::uint64_t& file_bytes, std::uint32_t slots, std::uint32_t words) {
  const FlightPlace place{file_bytes, slots, 0};
  file_bytes += (std::uint64_t{slots} * words * 4 + 63) / 64 * 64;
  return place;
}

std::string boot_id() {
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(in, id);
  return id;
}

}  // namespace

FlightRing::FlightRing(const std::string& path, const FlightPlan& plan) : path_(path) {
  const auto header = std::make_unique<FlightHeader>(plan.header);
  lay_out(plan, *header);
  look_at_former();
  rescue_part();
  try {
    place_ = std::make_unique<FilePlace>(path_, 0600);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string(error.what()) + " (--flight-ring FILE)");
  }
  map_file(*header);
  if (plan.waits) return;
  if (const std::string why = take_place(); !why.empty()) throw std::runtime_error(why);
}

FlightRing::~FlightRing() {
  this_thread_spans = nullptr;  // a run in virtual time has its jobs on this thread
  if (map_ != nullptr) munmap(map_, bytes_);
}

void FlightRing::lay_out(const FlightPlan& plan, FlightHeader& header) {
  std::memcpy(header.magic, kFlightMagic, sizeof(header.magic));
  header.version = kFlightVersion;
  header.header_bytes = kFlightHeaderBytes;
  header.pid = static_cast<std::uint32_t>(getpid());
  copy_text(header.boot_id, boot_id());
  header.groups = std::min(header.groups, kMaxGroups);
  header.file_bytes = kFlightHeaderBytes;
  for (std::uint32_t i = 0; i < header.groups; ++i) {
    FlightGroup& group = header.group[i];
    copy_text(header.track[i].name, group.name);
    group.period_ticks = std::max(group.period_ticks, 1u);
    group.tasks = std::min(group.tasks, kMaxTasksPerGroup);
    group.jobs = take(header.file_bytes, power_of_two(plan.ticks / group.period_ticks + 1), kJobWords);
  }
  const auto tracks = std::min<std::size_t>(header.groups + plan.more_tracks.size(), kMaxFlightTracks);
  header.tracks = static_cast<std::uint32_t>(tracks);
  for (std::uint32_t i = 0; i < header.tracks; ++i) {
    if (i >= header.groups) copy_text(header.track[i].name, plan.more_tracks[i - header.groups]);
    header.track[i].spans = take(header.file_bytes, power_of_two(plan.spans), kSpanWords);
  }
  header.events = take(header.file_bytes, power_of_two(plan.events), kEventWords);
  header.span_names = span_name_count();
  for (std::uint32_t i = 0; i < header.span_names; ++i) copy_text(header.span_name[i], span_name(i));
  header.check = flight_header_check(header);
  bytes_ = static_cast<std::size_t>(header.file_bytes);
}

// Never through a link, never over another user's file: /dev/shm belongs to everybody.
void FlightRing::look_at_former() {
  const int file = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) {
    if (errno == ENOENT) return;
    refuse(path_, std::string(std::strerror(errno)) + "; choose another file with --flight-ring FILE");
  }
  struct stat found {};
  const bool seen = fstat(file, &found) == 0;
  const bool lives = seen && flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(file);
  if (!seen || !S_ISREG(found.st_mode)) refuse(path_, "it is no ordinary file; choose another");
  if (found.st_uid != geteuid()) refuse(path_, "it belongs to another user; choose another file");
  if (lives) refuse(path_, "a run that is still going uses it; choose another file");
  if (FlightReader::is_blank(path_)) return;
  if (!FlightReader::is_ring(path_)) refuse(path_, "it exists and is no flight ring; choose another file");
  former_unfinished_ = !FlightReader::has_ended(path_);
  if (former_unfinished_) tell_kept();
}

// A run that died within its first job, before its ring took its place, is worth as much as any other.
void FlightRing::rescue_part() {
  const std::string part = path_ + ".part";
  if (!FlightReader::was_left(part)) return;
  try {
    const FlightReader reader(part);
    if (reader.jobs().empty() && reader.state().signal == 0) return;
  } catch (const std::runtime_error&) {
    return;
  }
  if (std::rename(part.c_str(), path_.c_str()) != 0)
    return;  // over a ring that would be kept no longer anyway
  if (!former_unfinished_) tell_kept();
  former_unfinished_ = true;
}

void FlightRing::tell_kept() {
  warnings_.push_back(
      "a run before this one did not end by itself; its last moments are kept: sortie export jobs " + path_ +
      ".previous");
}

std::string FlightRing::take_place() {
  return place_->take(former_unfinished_ ? FormerFile::kept : FormerFile::replaced);
}

void FlightRing::map_file(const FlightHeader& header) {
  // Space is taken now: a store into a page for which there is none later would kill the process.
  const int file = place_->descriptor();
  if (const int error = posix_fallocate(file, 0, static_cast<off_t>(bytes_)); error != 0) {
    refuse(path_, "no room for " + std::to_string(bytes_) + " bytes: " + std::strerror(error) +
                      "; keep fewer ticks with --flight-ticks, or choose another file");
  }
  void* map = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (map == MAP_FAILED) refuse(path_, std::string(std::strerror(errno)) + "; choose another file");
  map_ = static_cast<std::byte*>(map);
  if (!on_memory_file_system(file)) {
    warnings_.push_back(
        path_ +
        ": this flight ring lies on a disk: while the disk takes a page, a job that writes to it waits; "
        "put it below /dev/shm");
  }
  std::memset(map_, 0, bytes_);            // every page is there from now on
  static_cast<void>(mlock(map_, bytes_));  // a refusal is reported by lock_memory(), which asks for all
  std::memcpy(map_, &header, sizeof(header));
  state_ = reinterpret_cast<FlightState*>(map_ + kFlightStateOffset);
  const auto words_at = [this](const FlightPlace& place) {
    return reinterpret_cast<std::uint32_t*>(map_ + place.offset);
  };
  for (std::uint32_t i = 0; i < header.groups; ++i)
    jobs_[i] = {words_at(header.group[i].jobs), header.group[i].jobs.slots - 1, 0};
  tracks_ = std::make_unique<SpanTrack[]>(kMaxFlightTracks);
  for (std::uint32_t i = 0; i < header.tracks; ++i)
    tracks_[i] = SpanTrack(words_at(header.track[i].spans), header.track[i].spans.slots);
  events_ = {words_at(header.events), header.events.slots - 1, 0};
}

void FlightRing::set_clock(std::int64_t start_ns, std::int64_t utc_minus_monotonic_ns) {
  const auto header = std::make_unique<FlightHeader>();
  std::memcpy(header.get(), map_, sizeof(FlightHeader));
  header->start_ns = start_ns;
  header->utc_minus_monotonic_ns = utc_minus_monotonic_ns;
  header->check = flight_header_check(*header);
  std::memcpy(map_, header.get(), sizeof(FlightHeader));
}

void FlightRing::job(const JobRecord& record) noexcept {
  if (record.group >= kMaxGroups) return;
  FlightWriter& writer = jobs_[record.group];
  if (writer.first == nullptr) return;
  SpanTrack*& spans = this_thread_spans;
  if (spans != &tracks_[record.group]) spans = &tracks_[record.group];
  std::uint32_t words[kJobWords - 2]{};
  const auto started = static_cast<std::uint64_t>(record.started_ns);
  words[0] = static_cast<std::uint32_t>(record.tick);
  words[1] = static_cast<std::uint32_t>(record.tick >> 32);
  words[2] = static_cast<std::uint32_t>(started);
  words[3] = static_cast<std::uint32_t>(started >> 32);
  words[4] = static_cast<std::uint32_t>(record.verdict) | std::uint32_t{record.tasks} << 8 |
             std::uint32_t{record.level} << 16;
  words[5] = record.shed | std::uint32_t{record.cut} << 16;
  for (std::uint32_t i = 0; i < record.tasks && i < kMaxTasksPerGroup; ++i) {
    words[6 + i] = record.duration_ns[i];
    words[6 + kMaxTasksPerGroup + i] = record.units[i];
  }
  writer.add(words);
}

void FlightRing::event(Nanoseconds time_ns, Tick tick, std::string_view text) {
  std::uint32_t words[kEventWords - 2]{};
  const auto time = static_cast<std::uint64_t>(time_ns);
  const std::size_t length = std::min<std::size_t>(text.size(), kEventText);
  words[0] = static_cast<std::uint32_t>(time);
  words[1] = static_cast<std::uint32_t>(time >> 32);
  words[2] = static_cast<std::uint32_t>(tick);
  words[3] = static_cast<std::uint32_t>(tick >> 32);
  words[4] = static_cast<std::uint32_t>(length);
  std::memcpy(words + 5, text.data(), length);
  const std::lock_guard lock(event_mutex_);
  events_.add(words);
}

std::atomic<std::uint32_t>* FlightRing::running(std::uint32_t group) noexcept {
  static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));
  return reinterpret_cast<std::atomic<std::uint32_t>*>(&state_->running[group]);
}

void FlightRing::died(int signal, int code, const void* address) noexcept {
  std::uint32_t none = 0;
  if (!std::atomic_ref<std::uint32_t>(state_->signal)
           .compare_exchange_strong(none, static_cast<std::uint32_t>(signal)))
    return;
  state_->signal_ns = monotonic_now();
  state_->signal_code = code;
  state_->signal_address = reinterpret_cast<std::uintptr_t>(address);
  const SpanTrack* track = this_thread_spans;
  for (std::uint32_t i = 0; i < kMaxFlightTracks; ++i)
    if (track == &tracks_[i]) state_->signal_track = 1 + i;
}

void FlightRing::finish(Nanoseconds time_ns) noexcept {
  state_->ended_ns = time_ns;
  std::atomic_ref<std::uint32_t>(state_->ended).store(1, std::memory_order_release);
}

}  // namespace sortie::rt::posix
