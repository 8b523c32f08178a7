// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/export/flight_jobs.hpp"

#include <algorithm>
#include <ctime>
#include <ostream>

#include "firmware_like/log/compare.hpp"
#include "firmware_like/log/flight_ending.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {
namespace {

using rt::posix::FlightEvent;
using rt::posix::FlightGroup;
using rt::posix::FlightHeader;
using rt::posix::FlightJob;
using rt::posix::FlightReader;
using rt::posix::FlightSpan;

rt::Nanoseconds release_of(const FlightHeader& header, rt::Tick tick) {
  return header.epoch_ns + static_cast<rt::Nanoseconds>(tick) * header.base_tick_ns;
}

std::string as_microseconds(rt::Nanoseconds ns) {
  return firmware::format_fixed(static_cast<double>(ns) * 1e-3, 1);
}

bool bit(std::uint16_t bits, std::uint32_t index) { return ((bits >> index) & 1u) != 0; }

std::string date_of(const FlightHeader& header) {
  const auto seconds =
      static_cast<std::time_t>((header.start_ns + header.utc_minus_monotonic_ns) / rt::kNanosecondsPerSecond);
  std::tm parts{};
  char text[40]{};
  if (gmtime_r(&seconds, &parts) == nullptr ||
      std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S UTC", &parts) == 0)
    return "?";
  return text;
}

/// "imu 12.1, attitude 30.2 (cut at 40), map left out"
std::string tasks_of(const FlightGroup& group, const FlightJob& job) {
  std::string text;
  for (std::uint32_t i = 0; i < std::min(job.tasks, group.tasks); ++i) {
    text += (i > 0 ? ", " : "") + std::string(group.task[i]) + " ";
    if (bit(job.shed, i)) {
      text += "left out";
      continue;
    }
    text += as_microseconds(job.duration_ns[i]);
    if (bit(job.cut, i)) text += " (cut at " + std::to_string(job.units[i]) + ")";
    if (group.budget_us[i] > 0 && job.duration_ns[i] > group.budget_us[i] * 1000u)
      text += " (over its budget)";
  }
  return text;
}

}  // namespace

Trace to_trace(const FlightReader& ring) {
  const FlightHeader& header = ring.header();
  Trace trace;
  trace.process = "sortie " + std::string(header.scene);
  for (std::uint32_t i = 0; i < header.tracks; ++i)
    trace.tracks.push_back({static_cast<int>(i), header.track[i].name});
  for (const FlightJob& job : ring.jobs()) {
    const FlightGroup& group = header.group[job.group];
    const int track = static_cast<int>(job.group);
    trace.spans.push_back({std::string(group.name) + (job.verdict == rt::Verdict::missed ? " (missed)" : ""),
                           track,
                           job.started_ns,
                           job.ended_ns() - job.started_ns,
                           {{"tick", std::to_string(job.tick)},
                            {"late_us", as_microseconds(job.started_ns - release_of(header, job.tick))},
                            {"verdict", firmware::to_string(job.verdict)},
                            {"ladder", std::to_string(job.level)}}});
    rt::Nanoseconds at = job.started_ns;
    for (std::uint32_t i = 0; i < std::min(job.tasks, group.tasks); ++i) {
      if (!bit(job.shed, i)) {
        trace.spans.push_back({group.task[i], track, at, job.duration_ns[i], {}});
        if (job.units[i] > 0) trace.spans.back().details.emplace_back("units", std::to_string(job.units[i]));
      }
      at += job.duration_ns[i];
    }
  }
  for (const FlightSpan& span : ring.spans())
    trace.spans.push_back({span.name, static_cast<int>(span.track), span.begin_ns, span.duration_ns, {}});
  std::stable_sort(trace.spans.begin(), trace.spans.end(),
                   [](const TraceSpan& a, const TraceSpan& b) { return a.start_ns < b.start_ns; });
  for (const FlightEvent& event : ring.events()) trace.marks.push_back({event.text, event.time_ns});
  return trace;
}

void print_last_jobs(std::ostream& out, const FlightReader& ring, std::size_t count) {
  const FlightHeader& header = ring.header();
  out << "scene     " << header.scene << ", vehicle " << header.vehicle << ", version " << header.version_text
      << ", begun " << date_of(header) << "\nended     " << firmware::ending_of(ring) << '\n';
  if (ring.torn() > 0)
    out << "          " << ring.torn() << " entries were being written at that moment; they are left out\n";
  if (ring.damaged() > 0)
    out << "          " << ring.damaged() << " entries are damaged: the file was changed\n";
  std::size_t name_width = 5;
  for (std::uint32_t i = 0; i < header.groups; ++i)
    name_width = std::max(name_width, std::string(header.group[i].name).size());
  std::vector<std::size_t> left(header.groups, count);
  std::vector<const FlightJob*> shown;
  for (auto job = ring.jobs().rbegin(); job != ring.jobs().rend(); ++job) {
    if (left[job->group] == 0) continue;
    --left[job->group];
    shown.push_back(&*job);
  }
  std::reverse(shown.begin(), shown.end());
  out << firmware::pad_right("group", name_width) << firmware::pad_left("tick", 12)
      << firmware::pad_left("late [us]", 11) << firmware::pad_left("ran [us]", 11)
      << "  verdict  tasks [us]\n";
  for (const FlightJob* job : shown) {
    const FlightGroup& group = header.group[job->group];
    out << firmware::pad_right(group.name, name_width)
        << firmware::pad_left(firmware::group_digits(job->tick), 12)
        << firmware::pad_left(as_microseconds(job->started_ns - release_of(header, job->tick)), 11)
        << firmware::pad_left(as_microseconds(job->ended_ns() - job->started_ns), 11) << "  "
        << firmware::pad_right(firmware::to_string(job->verdict), 7) << "  " << tasks_of(group, *job)
        << (job->level > 0 ? "; ladder at " + std::to_string(job->level) : "") << '\n';
  }
  if (shown.empty()) out << "no job has run\n";
  const std::size_t events = ring.events().size();
  for (std::size_t i = events > count ? events - count : 0; i < events; ++i) {
    const FlightEvent& event = ring.events()[i];
    out << "event     tick " << firmware::group_digits(event.tick) << ": " << event.text << '\n';
  }
}

}  // namespace sortie::toolchain
