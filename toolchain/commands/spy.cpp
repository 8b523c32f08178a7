// SPDX-License-Identifier: BSD-3-Clause
// `sortie spy`: receive, count, show.
#include "toolchain/commands/spy.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "drivers/lcm_receiver.hpp"
#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/scene/json.hpp"
#include "rt/posix/clock.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/spy_table.hpp"

namespace sortie::toolchain {
namespace {

constexpr rt::Nanoseconds kRefresh = 500 * rt::kNanosecondsPerMillisecond;
constexpr int kWaitMs = 100;

rt::Nanoseconds utc_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::size_t terminal_rows() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 3 ? std::size_t{size.ws_row} - 2 : 22;
}

std::string summary(const drivers::LcmReceiverCounters& counters, const SpyTable& table) {
  std::string text = std::to_string(counters.messages) + " messages on " +
                     std::to_string(table.channels().size()) + " channels";
  if (counters.fragments != 0) text += ", " + std::to_string(counters.fragments) + " fragments not shown";
  if (counters.malformed != 0)
    text += ", " + std::to_string(counters.malformed) + " datagrams that are not LCM";
  if (table.dropped() != 0) text += ", " + std::to_string(table.dropped()) + " on channels beyond the table";
  return text;
}

void print_json(std::ostream& out, const SpyOptions& options, const drivers::LcmReceiverCounters& counters,
                const SpyTable& table, double seconds) {
  const firmware::Json object{{"url", options.url},
                              {"seconds", seconds},
                              {"channels", table.to_json(utc_now())},
                              {"counters",
                               {{"messages", counters.messages},
                                {"bytes", counters.bytes},
                                {"fragments", counters.fragments},
                                {"malformed", counters.malformed},
                                {"socket_errors", counters.socket_errors},
                                {"beyond_table", table.dropped()}}}};
  out << object.dump(2) << '\n';
}

}  // namespace

int run_spy(const SpyOptions& options, std::ostream& out, std::ostream& err) {
  try {
    static_cast<void>(drivers::parse_udpm_url(options.url));
  } catch (const std::runtime_error& error) {
    err << error.what() << '\n';
    return 2;
  }
  std::optional<drivers::LcmReceiver> receiver;
  try {
    receiver.emplace(options.url);
  } catch (const std::runtime_error& error) {
    err << error.what() << '\n';
    return 3;
  }
  const bool refresh =
      !options.json && options.seconds <= 0 && &out == &std::cout && isatty(STDOUT_FILENO) != 0;
  const firmware::StopSignals stop;
  SpyTable table(options.values);
  const rt::Nanoseconds start = rt::posix::monotonic_now();
  rt::Nanoseconds next_refresh = start;
  double elapsed_s = 0;
  while (!firmware::StopSignals::asked() && out && (options.seconds <= 0 || elapsed_s < options.seconds)) {
    drivers::ReceivedMessage received;
    const double left_ms = options.seconds > 0 ? 1e3 * (options.seconds - elapsed_s) + 1 : kWaitMs;
    const Status status =
        receiver->receive(received, left_ms < kWaitMs ? static_cast<int>(left_ms) : kWaitMs);
    if (status == Status::ok) {
      table.add(received.message.channel, received.message.payload, received.stamp_ns);
    } else if (status == Status::disconnected) {
      err << "LCM address \"" << options.url << "\": the socket failed\n";
      return 3;
    }
    const rt::Nanoseconds now = rt::posix::monotonic_now();
    elapsed_s = rt::to_seconds(now - start);
    if (refresh && now >= next_refresh) {
      next_refresh = now + kRefresh;
      out << "\033[H\033[J";  // top left, clear
      table.print(out, utc_now(), terminal_rows());
      out << summary(receiver->counters(), table) << "; Ctrl-C ends" << std::flush;
    }
  }
  if (refresh) out << "\033[H\033[J";
  if (options.json) {
    print_json(out, options, receiver->counters(), table, elapsed_s);
  } else {
    table.print(out, utc_now());
  }
  out << std::flush;
  err << summary(receiver->counters(), table) << '\n';
  if (receiver->counters().messages == 0) {
    err << "nothing was heard on " << options.url
        << "; is a program publishing there (`sortie run --scene NAME`), on this computer if ttl=0?\n";
  }
  return 0;
}

void add_spy(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<SpyOptions>();
  firmware::Command* command =
      app.add_subcommand("spy", "Watch live LCM channels: rate, jitter, bytes, age, values");
  command->footer(
      "Examples:\n"
      "  sortie spy\n"
      "  sortie spy --values --seconds 5\n"
      "  sortie spy --lcm-url 'udpm://239.255.76.67:7667?ttl=0' --json --seconds 2");
  command->add_option("--lcm-url", options->url, "Where to listen")->capture_default_str();
  command->add_option("--seconds", options->seconds, "Listen that long, then print once; 0: until Ctrl-C")
      ->in_range(0.0, 1e7);
  command->add_flag("--values", options->values, "Also show the latest numbers of each message");
  command->add_flag("--json", options->json, "Print one JSON object at the end");
  command->callback(context.choose([options] { return run_spy(*options, std::cout, std::cerr); }));
}

}  // namespace sortie::toolchain
