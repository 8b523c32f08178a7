// SPDX-License-Identifier: BSD-3-Clause
// A data set is a few files with one front and different endings: husky_a + _imu.csv, _odom.csv, _gps.csv.
#include "toolchain/import/data_set.hpp"

#include <algorithm>
#include <filesystem>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {
namespace {

namespace fs = std::filesystem;

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() > ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

std::vector<std::string> find_files(const std::string& path, const std::string& ending,
                                    const std::vector<std::string>& other_endings) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw firmware::InputError(path + ": no such file or folder; check the path");
  if (!fs::is_directory(status)) {
    if (ends_with(path, ending)) return {path};
    for (const std::string& other : other_endings) {
      if (ends_with(path, other)) return {path.substr(0, path.size() - other.size()) + ending};
    }
    return {path};  // whatever its name: its content is checked
  }
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    if (ends_with(entry.path().filename().string(), ending)) found.push_back(entry.path().string());
  }
  if (error)
    throw firmware::InputError(path + ": cannot be listed (" + error.message() + "); check its permissions");
  std::sort(found.begin(), found.end());
  return found;
}

std::string find_set(const std::string& path, const std::string& ending,
                     const std::vector<std::string>& other_endings, const char* kind) {
  const std::vector<std::string> found = find_files(path, ending, other_endings);
  if (found.empty()) {
    throw firmware::InputError(path + ": holds no *" + ending + "; give the folder of a " + kind +
                               " data set or one of its files");
  }
  if (found.size() > 1) {
    std::string list;
    for (const std::string& file : found)
      list += (list.empty() ? "" : ", ") + fs::path(file).filename().string();
    throw firmware::InputError(path + ": holds " + std::to_string(found.size()) + " " + kind +
                                   " data sets (" + list + "); name one of these files",
                               2);
  }
  if (!ends_with(found.front(), ending)) {
    throw firmware::InputError(found.front() + ": is not part of a " + kind + " data set by its name (*" +
                               ending + "); check the path and the kind");
  }
  return found.front().substr(0, found.front().size() - ending.size());
}

}  // namespace sortie::toolchain
