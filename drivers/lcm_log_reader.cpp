// SPDX-License-Identifier: BSD-3-Clause
// Maps a log file and walks it.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "drivers/lcm_log.hpp"

namespace sortie::drivers {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error(path + ": " + why);
}

std::string first_bytes(std::span<const std::uint8_t> bytes) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < bytes.size() && i < 4; ++i) {
    if (i != 0) text += ' ';
    text += kHex[bytes[i] >> 4];
    text += kHex[bytes[i] & 15];
  }
  return text;
}

// Opens, checks and maps; an empty file is an empty span.
std::span<const std::uint8_t> map_file(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0)
    refuse(path, std::string(std::strerror(errno)) + "; give the path of an LCM log");
  if (!S_ISREG(info.st_mode)) refuse(path, "is not a regular file; give the path of an LCM log");
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) refuse(path, std::string("cannot be opened: ") + std::strerror(errno));
  if (fstat(fd, &info) != 0 || info.st_size == 0) {
    close(fd);
    return {};
  }
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (size > static_cast<std::uint64_t>(std::numeric_limits<std::ptrdiff_t>::max())) {
    close(fd);
    refuse(path, "is too large for a 32-bit system; split it with lcm-logfilter or read it on a 64-bit one");
  }
  void* bytes = mmap(nullptr, static_cast<std::size_t>(size), PROT_READ, MAP_PRIVATE, fd, 0);
  const int error = errno;
  close(fd);
  if (bytes == MAP_FAILED) refuse(path, std::string("cannot be mapped: ") + std::strerror(error));
  madvise(bytes, static_cast<std::size_t>(size), MADV_SEQUENTIAL);
  return {static_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size)};
}

void unmap(std::span<const std::uint8_t> bytes) {
  if (!bytes.empty()) munmap(const_cast<std::uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace

LcmLogReader::LcmLogReader(const std::string& path) : bytes_(map_file(path)), cursor_(bytes_) {
  if (!bytes_.empty() && !begin_an_event(bytes_)) {
    const std::string found = first_bytes(bytes_);
    unmap(bytes_);
    refuse(path, "byte 0: is not an LCM event log (begins with " + found +
                     ", an LCM log with ed a1 da 01); `sortie import` makes one from a recording");
  }
}

LcmLogReader::~LcmLogReader() { unmap(bytes_); }

}  // namespace sortie::drivers
