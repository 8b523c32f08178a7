// SPDX-License-Identifier: BSD-3-Clause
// A temporary name beside the wanted one, then a rename, which is atomic on one file system.
#include "toolchain/export/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "firmware_like/scene/input_error.hpp"
#include "rt/posix/file_place.hpp"

namespace sortie::toolchain {
namespace {

/// Removes the temporary file unless it was renamed.
struct Removal {
  std::string path;
  ~Removal() {
    std::error_code ignored;
    if (!path.empty()) std::filesystem::remove(path, ignored);
  }
};

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
  throw firmware::InputError(path + ": cannot be written (" + reason +
                             "); choose another place with -o, or free some space");
}

}  // namespace

void write_file(const std::string& name, const std::function<void(std::ostream&)>& write) {
  if (name == "-") {
    write(std::cout);
    std::cout.flush();
    if (!std::cout) refuse("standard output", "it was closed or is full");
    return;
  }
  const std::string path = rt::posix::place_of(name);
  const bool direct = rt::posix::is_special_file(path);
  Removal part{direct ? std::string() : path + ".part"};
  errno = 0;
  std::ofstream out(direct ? path : part.path, std::ios::binary);
  if (!out) {
    part.path.clear();
    refuse(path, errno != 0 ? std::strerror(errno) : "cannot be created");
  }
  write(out);
  out.close();
  if (!out) refuse(path, errno != 0 ? std::strerror(errno) : "writing failed");
  if (direct) return;
  std::error_code error;
  std::filesystem::rename(part.path, path, error);
  if (error) refuse(path, error.message());
  part.path.clear();
}

void write_file(const std::string& name, const std::string& text) {
  write_file(name, [&text](std::ostream& out) { out << text; });
}

}  // namespace sortie::toolchain
