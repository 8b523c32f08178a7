// SPDX-License-Identifier: BSD-3-Clause
// Locale-free reading of numbers: std::from_chars for doubles, integer arithmetic for stamps.
#include "toolchain/import/text_file.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <limits>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

bool parse_double(std::string_view text, double& value) {
  text = trim(text);
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() && !text.empty();
}

bool parse_seconds(std::string_view text, std::int64_t& nanoseconds) {
  text = trim(text);
  bool negative = false;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  // Digits as one integer, `point` of them before the decimal point.
  std::string digits;
  int point = 0;
  bool seen_point = false;
  std::size_t i = 0;
  for (; i < text.size() && (is_digit(text[i]) || (text[i] == '.' && !seen_point)); ++i) {
    if (text[i] == '.') {
      seen_point = true;
    } else {
      digits.push_back(text[i]);
      if (!seen_point) ++point;
    }
  }
  if (digits.empty()) return false;
  int exponent = 0;
  if (i < text.size()) {
    if (text[i] != 'e' && text[i] != 'E') return false;
    std::string_view rest = text.substr(i + 1);
    if (!rest.empty() && rest.front() == '+') rest.remove_prefix(1);
    const auto result = std::from_chars(rest.data(), rest.data() + rest.size(), exponent);
    if (rest.empty() || result.ec != std::errc{} || result.ptr != rest.data() + rest.size()) return false;
  }
  if (exponent > 400 || exponent < -400) return false;
  const int wanted = point + exponent + 9;  // digits that make up whole nanoseconds
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  std::int64_t sum = 0;
  for (int d = 0; d < wanted; ++d) {
    const int digit = d < static_cast<int>(digits.size()) ? digits[static_cast<std::size_t>(d)] - '0' : 0;
    if (sum > (kMost - digit) / 10) return false;
    sum = sum * 10 + digit;
  }
  const bool round_up = wanted >= 0 && wanted < static_cast<int>(digits.size()) &&
                        digits[static_cast<std::size_t>(wanted)] >= '5';
  if (round_up && sum == kMost) return false;
  sum += round_up ? 1 : 0;
  nanoseconds = negative ? -sum : sum;
  return true;
}

TextFile::TextFile(const std::string& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw firmware::InputError(path + ": no such file; give the path of an existing file");
  if (std::filesystem::is_directory(path, error))
    throw firmware::InputError(path + ": is a folder, a file was expected");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw firmware::InputError(path + ": cannot be opened; check its permissions");
  text_.assign(std::istreambuf_iterator<char>(in), {});
  if (in.bad()) throw firmware::InputError(path + ": reading failed; check the disk and copy the file again");
  const std::size_t zero = text_.find('\0');
  if (zero != std::string::npos) {
    throw firmware::InputError(path + ": is no text file (zero byte at offset " + std::to_string(zero) +
                               "); give the text file of the data set");
  }
}

bool TextFile::next(std::string_view& line) {
  const std::size_t end = text_.find('\n', next_);
  if (end == std::string::npos) return false;
  line = std::string_view(text_).substr(next_, end - next_);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  next_ = end + 1;
  ++line_;
  return true;
}

std::string_view TextFile::tail() const {
  const std::size_t last = text_.rfind('\n');
  return last == std::string::npos ? std::string_view(text_) : std::string_view(text_).substr(last + 1);
}

std::string TextFile::place() const { return path_ + ":" + std::to_string(line_); }

std::string quote(std::string_view text) {
  std::string shown = "'";
  for (const char c : text.substr(0, 32)) shown.push_back(c >= ' ' && c < 127 ? c : '?');
  return shown + (text.size() > 32 ? "...'" : "'");
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  if (separator == ' ') {
    std::size_t i = 0;
    while (i < line.size()) {
      while (i < line.size() && is_blank(line[i])) ++i;
      std::size_t begin = i;
      while (i < line.size() && !is_blank(line[i])) ++i;
      if (i > begin) fields.push_back(line.substr(begin, i - begin));
    }
    return;
  }
  while (true) {
    const std::size_t cut = line.find(separator);
    fields.push_back(trim(line.substr(0, cut)));
    if (cut == std::string_view::npos) return;
    line.remove_prefix(cut + 1);
  }
}

}  // namespace sortie::toolchain
