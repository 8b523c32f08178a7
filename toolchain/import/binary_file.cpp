// SPDX-License-Identifier: BSD-3-Clause
// Loading and the check of the first bytes.
#include "toolchain/import/binary_file.hpp"

#include <bit>
#include <filesystem>
#include <fstream>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in the file");

BinaryFile::BinaryFile(const std::string& path, std::string_view magic, const char* what) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw firmware::InputError(path + ": no such file; check the path");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw firmware::InputError(path + ": cannot be opened; check its permissions");
  bytes_.assign(std::istreambuf_iterator<char>(in), {});
  if (in.bad()) throw firmware::InputError(path + ": reading failed; check the disk and copy the file again");
  if (std::string_view(bytes_.data(), bytes_.size()).substr(0, magic.size()) != magic) {
    throw firmware::InputError(path + ": is not " + what + ": it does not begin with '" + std::string(magic) +
                               "' (byte 0); check the path and the kind");
  }
  position_ = magic.size();
}

}  // namespace sortie::toolchain
