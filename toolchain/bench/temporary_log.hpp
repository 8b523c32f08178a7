// SPDX-License-Identifier: BSD-3-Clause
// A folder of a command's own for logs that nobody keeps.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {

/// Made when it is constructed, gone with all that is in it when it is destroyed.
class TemporaryFolder {
 public:
  /// `name`: what its own begins with. Throws InputError with the cure.
  explicit TemporaryFolder(const std::string& name = "sortie")
      : name_((std::filesystem::temp_directory_path() / (name + "-XXXXXX")).string()) {
    if (mkdtemp(name_.data()) == nullptr) throw firmware::InputError(name_ + ": cannot be made; set TMPDIR");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(name_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return name_ + "/" + name; }

 private:
  std::string name_;
};

}  // namespace sortie::toolchain
