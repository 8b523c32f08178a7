// SPDX-License-Identifier: BSD-3-Clause
// LCM's own logger and player against our log, publisher and receiver, in a network of the test's own.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/lcm_publisher.hpp"
#include "drivers/lcm_receiver.hpp"
#include "tests/drivers/own_network.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

using Bytes = std::vector<std::uint8_t>;

const std::string kUrl = "udpm://239.255.76.67:7670?ttl=0";

bool installed(const char* tool) {
  return std::system((std::string("command -v ") + tool + " >/dev/null 2>&1").c_str()) == 0;
}

// Empty, or why these tests cannot run here.
std::string hindrance() {
  if (!installed("lcm-logger") || !installed("lcm-logplayer"))
    return "lcm-logger or lcm-logplayer is missing";
  return test::enter_own_network();
}

// A program in the background; asked to end, and waited for, at the end of the scope.
class Background {
 public:
  explicit Background(std::vector<std::string> words) : child_(fork()) {
    if (child_ != 0) return;
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~Background() {
    kill(child_, SIGINT);
    waitpid(child_, nullptr, 0);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

 private:
  pid_t child_;
};

}  // namespace

TEST_CASE("lcm-logplayer plays our log and our receiver hears every event") {
  if (const std::string why = hindrance(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  const auto path =
      std::filesystem::temp_directory_path() / ("sortie_play_" + std::to_string(getpid()) + ".lcm");
  constexpr int kEvents = 100;
  {
    LcmLogWriter writer(path.string());
    for (int i = 0; i < kEvents; ++i) {
      const Bytes data(static_cast<std::size_t>(i) * 7, static_cast<std::uint8_t>(i));
      REQUIRE(writer.append(i % 2 == 0 ? "EVEN" : "ODD", 1'000'000 + i * 2000, data) == Status::ok);
    }
    REQUIRE(writer.close() == Status::ok);
  }
  LcmReceiver receiver(kUrl);
  {
    const Background player({"lcm-logplayer", "--lcm-url=" + kUrl, path.string()});
    for (int i = 0; i < kEvents; ++i) {
      ReceivedMessage received;
      REQUIRE(receiver.receive(received, 10'000) == Status::ok);
      CHECK(received.message.channel == (i % 2 == 0 ? "EVEN" : "ODD"));
      const Bytes data(received.message.payload.begin(), received.message.payload.end());
      CHECK(data == Bytes(static_cast<std::size_t>(i) * 7, static_cast<std::uint8_t>(i)));
    }
  }
  std::filesystem::remove(path);
}

TEST_CASE("lcm-logger records what we publish and our reader reads its log") {
  if (const std::string why = hindrance(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  const auto path =
      std::filesystem::temp_directory_path() / ("sortie_record_" + std::to_string(getpid()) + ".lcm");
  std::uint32_t sent = 0;
  {
    LcmPublisher publisher({kUrl, 64, 256});
    REQUIRE(publisher.active());
    const Background logger(
        {"lcm-logger", "-q", "-f", "--flush-interval=50", "--lcm-url=" + kUrl, path.string()});
    // Until something is in the file: starting takes the logger a while.
    const auto recorded = [&path] {
      std::error_code none;
      const auto size = std::filesystem::file_size(path, none);
      return !none && size > 1000;
    };
    for (int tries = 0; tries < 2000 && !recorded(); ++tries) {
      Bytes message(64, static_cast<std::uint8_t>(sent));
      std::memcpy(message.data(), &sent, 4);
      if (publisher.publish("NUMBERED", message) == Status::ok) ++sent;
      usleep(5000);
    }
  }
  LcmLogReader reader(path.string());
  LogEvent event;
  std::uint32_t last = 0;
  std::uint64_t events = 0;
  while (reader.next(event) == Status::ok) {
    std::uint32_t number = 0;
    REQUIRE(event.channel == "NUMBERED");
    REQUIRE(event.data.size() == 64);
    std::memcpy(&number, event.data.data(), 4);
    REQUIRE(event.data[63] == static_cast<std::uint8_t>(number));
    if (events != 0) REQUIRE(number == last + 1);
    last = number;
    ++events;
  }
  std::filesystem::remove(path);
  CHECK(events > 5);
  CHECK(events <= sent);
  CHECK(reader.next(event) == Status::empty);
}
