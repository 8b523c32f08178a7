// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/secret.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>

#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kMakeOne = "make one: head -c 16 /dev/urandom | xxd -p > FILE && chmod 600 FILE";

// A descriptor that is closed whatever happens.
struct Descriptor {
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  int fd;
};

[[noreturn]] void refuse_unreadable(const std::string& path) {
  throw ProfileError(path + ": the secret cannot be read (" + std::strerror(errno) + "); " + kMakeOne);
}

// Every question is put to the descriptor, none to the path: what was judged is what is read. Opened so that
// neither a FIFO nor a device can make it wait, and no link leads elsewhere.
std::string read_private(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC | O_NOCTTY)};
  if (file.fd < 0 && errno == ELOOP)
    throw ProfileError(path + ": the secret is a link, which may lead anywhere; name the file itself");
  struct stat status {};
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) refuse_unreadable(path);
  if (!S_ISREG(status.st_mode)) throw ProfileError(path + ": the secret is no regular file; " + kMakeOne);
  if (status.st_uid != ::geteuid() && status.st_uid != 0)
    throw ProfileError(path + ": the secret belongs to user " + std::to_string(status.st_uid) +
                       ", who can change it; chown " + std::to_string(::geteuid()) + " " + path);
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw ProfileError(path + ": others may read or write this secret; chmod 600 " + path);
  std::string text(64, '\0');
  ssize_t size = 0;
  do size = ::read(file.fd, text.data(), text.size());
  while (size < 0 && errno == EINTR);
  if (size < 0) refuse_unreadable(path);
  text.resize(static_cast<std::size_t>(size));
  return text;
}

}  // namespace

drivers::SipKey read_secret(const std::string& path) {
  std::string text = read_private(path);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.pop_back();
  drivers::SipKey key{};
  bool good = text.size() == 2 * key.size();
  for (std::size_t i = 0; good && i < key.size(); ++i) {
    const char* const at = text.data() + 2 * i;
    good = std::from_chars(at, at + 2, key[i], 16).ptr == at + 2;
  }
  if (!good) throw ProfileError(path + ": a secret is 32 hexadecimal digits; " + kMakeOne);
  return key;
}

std::int64_t unguessable_number() {
  std::uint8_t bytes[8];
  if (::getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes))
    throw std::runtime_error(std::string("no random numbers from the system: ") + std::strerror(errno));
  std::uint64_t number = 0;
  std::memcpy(&number, bytes, sizeof bytes);
  number >>= 1;
  return static_cast<std::int64_t>(number == 0 ? 1 : number);
}

}  // namespace sortie::firmware
