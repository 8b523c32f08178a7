// SPDX-License-Identifier: BSD-3-Clause
// The signals that end a run in order: which are heard, and whose they are afterwards.
#include "firmware_like/live/stop_signals.hpp"

#include <catch2/catch.hpp>
#include <csignal>

namespace sortie::firmware {

namespace {

using Handler = void (*)(int);

Handler handler_of(int signal) {
  struct sigaction now {};
  sigaction(signal, nullptr, &now);
  return now.sa_handler;
}

void somebodys(int) {}

}  // namespace

TEST_CASE("a run hears who asks for its end, and each signal is its owner's again afterwards") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    INFO("signal " << signal);
    const Handler before = std::signal(signal, somebodys);
    {
      const StopSignals signals;
      CHECK_FALSE(StopSignals::asked().load());
      CHECK(StopSignals::number() == 0);
      std::raise(signal);
      CHECK(StopSignals::asked().load());
      CHECK(StopSignals::number() == signal);
    }
    CHECK(handler_of(signal) == somebodys);
    {
      const StopSignals again;  // what the run before was asked for is not asked of this one
      CHECK_FALSE(StopSignals::asked().load());
      CHECK(StopSignals::number() == 0);
    }
    std::signal(signal, before);
  }
}

TEST_CASE("a run that shall outlive its terminal goes on when the terminal is gone") {
  const Handler before = std::signal(SIGHUP, SIG_IGN);  // as nohup leaves it
  {
    const StopSignals signals;
    std::raise(SIGHUP);
    CHECK_FALSE(StopSignals::asked().load());
  }
  CHECK(handler_of(SIGHUP) == SIG_IGN);
  std::signal(SIGHUP, before);
}

}  // namespace sortie::firmware
