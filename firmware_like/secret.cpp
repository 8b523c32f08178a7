// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/secret.hpp"

#include <sys/random.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <stdexcept>

#include "firmware_like/profile.hpp"

namespace sortie::firmware {

namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

drivers::SipKey read_secret(const std::string& path) {
  struct stat status {};
  std::ifstream file(path, std::ios::binary);
  if (!file || ::stat(path.c_str(), &status) != 0)
    throw ProfileError(path +
                       ": the secret cannot be read; make one: head -c 16 /dev/urandom | xxd -p > FILE");
  if ((status.st_mode & (S_IRGRP | S_IROTH | S_IWGRP | S_IWOTH)) != 0)
    throw ProfileError(path + ": others may read or write this secret; chmod 600 " + path);
  std::string text(64, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.pop_back();
  drivers::SipKey key{};
  bool good = text.size() == 2 * key.size();
  for (std::size_t i = 0; good && i < key.size(); ++i) {
    const int high = hex_digit(text[2 * i]);
    const int low = hex_digit(text[2 * i + 1]);
    good = high >= 0 && low >= 0;
    key[i] = static_cast<std::uint8_t>(good ? 16 * high + low : 0);
  }
  if (!good)
    throw ProfileError(
        path + ": a secret is 32 hexadecimal digits; make one: head -c 16 /dev/urandom | xxd -p > FILE");
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
