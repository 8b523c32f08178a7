// SPDX-License-Identifier: BSD-3-Clause
// What a run tells its supervisor, and that one that is not there, or does not take it, harms nothing.
#include "drivers/service_notify.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/firmware_like/temp_folder.hpp"

using sortie::drivers::ServiceNotify;
using sortie::testing::TempFolder;

namespace {

struct NotifyRig {
  int socket{::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)};
  explicit NotifyRig(const std::string& name) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    const bool has_file = name[0] == '/';
    if (!has_file) address.sun_path[0] = '\0';
    const auto size =
        static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size() + (has_file ? 1 : 0));
    REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0);
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
    setenv("WATCHDOG_USEC", "4000000", 1);
    unsetenv("WATCHDOG_PID");
  }
  ~NotifyRig() {
    ::close(socket);
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    unsetenv("WATCHDOG_PID");
  }
  NotifyRig(const NotifyRig&) = delete;
  NotifyRig& operator=(const NotifyRig&) = delete;
  std::string heard() const {
    char text[64];
    const ssize_t size = ::recv(socket, text, sizeof text, 0);
    return size < 0 ? "" : std::string(text, static_cast<std::size_t>(size));
  }
};

}  // namespace

TEST_CASE("a supervisor hears ready, four signs of life in its time, and the end") {
  const TempFolder folder;
  const std::string file = folder.file("notify");
  const std::string unseen = "@sortie-test-" + std::to_string(getpid());
  for (const std::string& name : {file, unseen}) {
    const NotifyRig rig(name);
    ServiceNotify service;
    service.ready();
    CHECK(rig.heard() == "READY=1");
    int signs = 0;
    for (sortie::rt::Nanoseconds now = 0; now < 4 * sortie::rt::kNanosecondsPerSecond;
         now += sortie::rt::kNanosecondsPerSecond / 20) {
      service.alive(now);
      const std::string said = rig.heard();
      CHECK((said.empty() || said == "WATCHDOG=1"));
      signs += said.empty() ? 0 : 1;
    }
    CHECK(signs == 4);
    service.stopping();
    CHECK(rig.heard() == "STOPPING=1");
    CHECK(service.sent() == 6);
    CHECK(service.refused() == 0);
  }
}

TEST_CASE(
    "without a supervisor, with another's watchdog or a full socket nothing is said, and nothing waits") {
  unsetenv("NOTIFY_SOCKET");
  CHECK_FALSE(ServiceNotify().wanted());
  setenv("NOTIFY_SOCKET", "relative", 1);
  CHECK_FALSE(ServiceNotify().wanted());
  setenv("NOTIFY_SOCKET", ("/" + std::string(200, 'x')).c_str(), 1);
  CHECK_FALSE(ServiceNotify().wanted());
  const TempFolder folder;
  const NotifyRig rig(folder.file("notify"));
  setenv("WATCHDOG_PID", "1", 1);
  ServiceNotify other;
  other.alive(sortie::rt::kNanosecondsPerSecond);
  CHECK(rig.heard().empty());
  setenv("WATCHDOG_USEC", "soon", 1);
  unsetenv("WATCHDOG_PID");
  ServiceNotify none;
  none.alive(sortie::rt::kNanosecondsPerSecond);
  CHECK(rig.heard().empty());
  for (int i = 0; i < 10'000; ++i) other.ready();  // nobody takes them
  CHECK(other.refused() > 0);
  CHECK(other.sent() + other.refused() == 10'000);
}
