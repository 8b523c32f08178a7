// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/flight_ending.hpp"

#include <csignal>
#include <cstdio>
#include <utility>

namespace sortie::firmware {
namespace {

using rt::posix::FlightHeader;
using rt::posix::FlightReader;

const char* signal_name(int number) {
  constexpr std::pair<int, const char*> kNames[] = {
      {SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"},       {SIGFPE, "SIGFPE"},   {SIGILL, "SIGILL"},
      {SIGABRT, "SIGABRT"}, {SIGTRAP, "SIGTRAP"},     {SIGSYS, "SIGSYS"},   {SIGQUIT, "SIGQUIT"},
      {SIGALRM, "SIGALRM"}, {SIGVTALRM, "SIGVTALRM"}, {SIGPROF, "SIGPROF"}, {SIGXCPU, "SIGXCPU"},
      {SIGUSR1, "SIGUSR1"}, {SIGUSR2, "SIGUSR2"}};
  for (const auto& [known, name] : kNames)
    if (known == number) return name;
  return "another signal";
}

std::string signal_of(const FlightReader& ring) {
  const rt::posix::FlightState& state = ring.state();
  if (state.signal == 0)
    return " without a signal that can be caught (kill -9, no memory left, or it gave up with an error)";
  const auto number = static_cast<int>(state.signal);
  const char* name = signal_name(number);
  char text[120];
  const char* whose = state.signal_code > 0           ? ", its own fault"
                      : state.signal_code == SI_TKILL ? ", its own doing"
                                                      : ", sent by another process";
  std::snprintf(text, sizeof(text), " of %s%s, at %.3f s", name, whose,
                static_cast<double>(state.signal_ns - ring.header().start_ns) * 1e-9);
  std::string all = text;
  if (state.signal_track > 0 && state.signal_track <= ring.header().tracks)
    all += " in thread " + std::string(ring.header().track[state.signal_track - 1].name);
  return all;
}

}  // namespace

std::string ending_of(const FlightReader& ring) {
  const FlightHeader& header = ring.header();
  if (ring.ended()) return "the run ended by itself";
  if (ring.writer_lives()) return "process " + std::to_string(header.pid) + " still runs";
  std::string text = "process " + std::to_string(header.pid) + " died" + signal_of(ring);
  if (!ring.jobs().empty()) text += "; last tick " + std::to_string(ring.jobs().back().tick);
  std::string where;
  for (std::uint32_t i = 0; i < header.groups; ++i) {
    if (const int task = ring.running(i); task >= 0)
      where += (where.empty() ? "" : " and ") + std::string(header.group[i].task[task]) + " (group " +
               header.group[i].name + ")";
  }
  return text + (where.empty() ? "; no task was running" : "; running was " + where);
}

}  // namespace sortie::firmware
