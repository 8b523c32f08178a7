// SPDX-License-Identifier: BSD-3-Clause
// A file of little-endian numbers in memory; every read is checked against its end.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::toolchain {

/// Reads a whole file and hands out numbers one after the other.
class BinaryFile {
 public:
  /// Throws InputError if the file cannot be read or does not begin with `magic`; `what` is said to be
  /// expected then.
  BinaryFile(const std::string& path, std::string_view magic, const char* what);

  /// Reads one number and steps on; false, and nothing changed, if the file ends before it.
  template <class T>
  bool get(T& value) {
    if (left() < sizeof(T)) return false;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return true;
  }

  std::uint64_t position() const { return position_; }
  std::uint64_t left() const { return bytes_.size() - position_; }

 private:
  std::vector<char> bytes_;
  std::size_t position_{};
};

}  // namespace sortie::toolchain
