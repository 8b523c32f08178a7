// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/profile_text.hpp"

namespace sortie::firmware {

namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// Where the quotes that begin at `at` end: the place behind them, or of the line's end where they do not end.
std::size_t behind_quotes(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view three = text.substr(at, 3);
  const bool over_lines = three.size() == 3 && three[1] == quote && three[2] == quote;
  std::size_t i = at + (over_lines ? 3 : 1);
  while (i < text.size()) {
    if (text[i] == '\\' && quote == '"') {
      i += 2;
    } else if (text[i] == '\n' && !over_lines) {
      return i;
    } else if (text[i] != quote) {
      ++i;
    } else if (!over_lines) {
      return i + 1;
    } else if (text.substr(i, 3) == three) {
      i += 3;
      while (i < text.size() && text[i] == quote) ++i;  // quotes may stand before the three that end it
      return i;
    } else {
      ++i;
    }
  }
  return text.size();
}

}  // namespace

std::size_t line_of_bare_non_ascii(std::string_view toml) {
  std::size_t line = 1;
  std::size_t i = toml.substr(0, 3) == kByteOrderMark ? 3 : 0;
  while (i < toml.size()) {
    std::size_t next = i + 1;
    if (toml[i] == '#') {
      next = toml.find('\n', i);
      if (next == std::string_view::npos) return 0;
    } else if (toml[i] == '"' || toml[i] == '\'') {
      next = behind_quotes(toml, i);
    } else if (static_cast<unsigned char>(toml[i]) > 127) {
      return line;
    }
    for (; i < next; ++i) line += toml[i] == '\n' ? 1 : 0;
  }
  return 0;
}

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xc2 ? 0
                               : first < 0xe0 ? 2
                               : first < 0xf0 ? 3
                               : first < 0xf5 ? 4
                                              : 0;
    if (length == 0 || text.size() - i < length) return false;
    for (std::size_t k = 1; k < length; ++k) {
      if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return false;
    }
    const unsigned second = length > 1 ? static_cast<unsigned char>(text[i + 1]) : 0x80u;
    if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
        (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f)) {
      return false;
    }
    i += length;
  }
  return true;
}

}  // namespace sortie::firmware
