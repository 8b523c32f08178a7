// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/doctor/machine_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

constexpr std::size_t kMostBytes = 1u << 20;
constexpr std::int64_t kMostCores = 4096;

}  // namespace

MachineFiles::MachineFiles(std::string root) : root_(std::move(root)) {
  while (!root_.empty() && root_.back() == '/') root_.pop_back();
}

std::optional<std::string> MachineFiles::read(const std::string& path) const {
  const std::string full = root_ + path;
  std::error_code error;
  if (std::filesystem::is_directory(full, error)) return std::nullopt;
  std::ifstream in(full, std::ios::binary);
  if (!in) return std::nullopt;
  std::string text;
  for (char block[4096]; text.size() < kMostBytes;) {
    in.read(block, sizeof(block));
    if (in.gcount() <= 0) break;
    text.append(block, static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) return std::nullopt;
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::optional<std::int64_t> MachineFiles::number(const std::string& path) const {
  const std::optional<std::string> text = read(path);
  if (!text) return std::nullopt;
  const std::vector<std::string> words = split_words(*text);
  return words.empty() ? std::nullopt : to_number(words.front());
}

std::vector<std::string> MachineFiles::names(const std::string& folder) const {
  std::vector<std::string> found;
  std::error_code error;
  std::filesystem::directory_iterator it(root_ + folder, error);
  for (const std::filesystem::directory_iterator end; !error && it != end; it.increment(error)) {
    found.push_back(it->path().filename().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool MachineFiles::exists(const std::string& path) const {
  std::error_code error;
  return std::filesystem::exists(root_ + path, error);
}

bool MachineFiles::writable(const std::string& path) const {
  return access((root_ + path).c_str(), W_OK) == 0;
}

std::vector<int> parse_core_list(const std::string& text) {
  std::vector<int> cores;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t dash = part.find('-');
    const std::optional<std::int64_t> first = to_number(part.substr(0, dash));
    const std::optional<std::int64_t> last =
        dash == std::string::npos ? first : to_number(part.substr(dash + 1));
    if (!first || !last || *first < 0 || *last > kMostCores) return {};
    for (std::int64_t core = *first; core <= *last; ++core) cores.push_back(static_cast<int>(core));
  }
  return cores;
}

std::string describe_cores(const std::vector<int>& cores) {
  std::string text;
  for (std::size_t i = 0; i < cores.size();) {
    std::size_t end = i + 1;
    while (end < cores.size() && cores[end] == cores[end - 1] + 1) ++end;
    text += (text.empty() ? "" : ",") + std::to_string(cores[i]);
    if (end - i > 1) text += "-" + std::to_string(cores[end - 1]);
    i = end;
  }
  return text.empty() ? "none" : text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(std::move(line));
  return lines;
}

std::optional<std::int64_t> to_number(const std::string& word) {
  std::int64_t value = 0;
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (word.empty() || result.ec != std::errc() || result.ptr != end) return std::nullopt;
  return value;
}

}  // namespace sortie::firmware
