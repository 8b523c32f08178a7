// SPDX-License-Identifier: BSD-3-Clause
// The hold on the processor's idle states: what is written, that it lasts as long as the object, and what a
// refusal says.
#include "rt/posix/cpu_latency.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

namespace sortie::rt::posix {
namespace {

// Descriptors of this process that point at `path`.
int open_descriptors(const std::string& path) {
  int found = 0;
  for (int fd = 0; fd < 256; ++fd) {
    char target[512]{};
    const std::string link = "/proc/self/fd/" + std::to_string(fd);
    if (readlink(link.c_str(), target, sizeof(target) - 1) > 0 && path == target) ++found;
  }
  return found;
}

struct DeviceFile {
  std::string path{"/tmp/sortie-latency-XXXXXX"};
  DeviceFile() {
    const int fd = mkstemp(path.data());
    REQUIRE(fd >= 0);
    const char before[] = "xxxx";
    REQUIRE(write(fd, before, 4) == 4);
    close(fd);
  }
  ~DeviceFile() { unlink(path.c_str()); }
  DeviceFile(const DeviceFile&) = delete;
  DeviceFile& operator=(const DeviceFile&) = delete;
};

}  // namespace

TEST_CASE("the idle states are held off with a 32 bit zero for as long as the hold lives") {
  const DeviceFile device;
  {
    const CpuLatencyHold hold(device.path.c_str());
    CHECK(hold.result().ok);
    CHECK(std::string(hold.result().reason).empty());
    CHECK(open_descriptors(device.path) == 1);
    const int fd = open(device.path.c_str(), O_RDONLY);
    char content[8]{};
    CHECK(read(fd, content, sizeof(content)) == 4);
    CHECK(std::memcmp(content, "\0\0\0\0", 4) == 0);
    close(fd);
  }
  CHECK(open_descriptors(device.path) == 0);
}

TEST_CASE("a refused hold names the device and the cure and holds no file") {
  const CpuLatencyHold hold("/no/such/device");
  CHECK_FALSE(hold.result().ok);
  const std::string reason = hold.result().reason;
  CHECK(reason.find("/no/such/device") != std::string::npos);
  CHECK(reason.find("chmod") != std::string::npos);
  CHECK(reason.find('\n') == std::string::npos);
  const CpuLatencyHold full("/dev/full");  // opens, and refuses what is written
  if (access("/dev/full", W_OK) == 0) {
    CHECK_FALSE(full.result().ok);
    CHECK(open_descriptors("/dev/full") == 0);
  }
}

}  // namespace sortie::rt::posix
