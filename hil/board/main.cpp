// SPDX-License-Identifier: BSD-3-Clause
// What an emulated board's jobs need beside the program itself, in one small program.
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

#include "drivers/can_link.hpp"
#include "hil/board/board_jobs.hpp"

namespace {

std::uint32_t whole_number(const char* text) {
  return static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

int told(bool good, const std::string& problem) { return good ? 0 : sortie::hil::complain(problem); }

}  // namespace

int main(int count, char** words) {
  const std::span<char*> arguments(words, static_cast<std::size_t>(count));
  const std::string command = count > 1 ? arguments[1] : "";
  std::string problem;
  if (command == "vcan" && count == 3)
    return told(sortie::drivers::make_virtual_can(arguments[2], problem), problem);
  if (command == "bitrate" && count == 4) {
    return told(sortie::drivers::set_can_bitrate(arguments[2], whole_number(arguments[3]), problem), problem);
  }
  if (command == "isolated" && count >= 5)
    return sortie::hil::run_isolated(arguments[2], whole_number(arguments[3]), &arguments[4]);
  if (command == "watch" && count == 4) return sortie::hil::watch_bus(arguments[2], arguments[3]);
  if (command == "kill" && count == 3)
    return sortie::hil::kill_process(static_cast<int>(whole_number(arguments[2])));
  if (command == "flood" && count == 6) {
    return sortie::hil::flood(
        {arguments[2], arguments[3], whole_number(arguments[4]), whole_number(arguments[5])});
  }
  if (command == "fd" && count == 5)
    return sortie::hil::fd_frames(arguments[2], arguments[3], whole_number(arguments[4]));
  if (command == "overrun" && count == 4)
    return sortie::hil::overrun(arguments[2], whole_number(arguments[3]));
  if (command == "storm" && count == 5)
    return sortie::hil::storm(arguments[2], whole_number(arguments[3]), whole_number(arguments[4]));
  std::fprintf(
      stderr,
      "usage: sortie_board vcan NAME | bitrate NAME BITS_PER_S (0: off) | isolated NAME BITS_PER_S "
      "PROGRAM ARG...\n"
      "       | watch NAME FILE (until SIGTERM) | kill PROCESS | flood NEAR FAR FRAMES PER_MS\n"
      "       | fd NAME NAME_WITHOUT_FD FRAMES | overrun NAME FRAMES | storm URL DATAGRAMS PER_MS\n");
  return 2;
}
