// SPDX-License-Identifier: BSD-3-Clause
// Rows of numbers from text files, independent of the locale and with line numbers for messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::toolchain {

/// A decimal number, blanks around it allowed; "nan" and "inf" are numbers, too. False where it is none.
bool parse_double(std::string_view text, double& value);

/// Decimal seconds, with or without exponent, as nanoseconds: exact, rounded half away from zero. A double
/// would keep only 0.2 us of a stamp of today. False where it is no finite number or leaves +-292 years.
bool parse_seconds(std::string_view text, std::int64_t& nanoseconds);

/// The farthest from 0, 4.5e9 s, of a stamp that may be negative: differences of two cannot overflow.
inline constexpr std::int64_t kFarthestStamp_ns = 4'500'000'000 * std::int64_t{1'000'000'000};
/// The latest stamp that a recording of poses or scans may have, 9e9 s: differences of two cannot overflow.
inline constexpr std::int64_t kLatestStamp_ns = 9'000'000'000 * std::int64_t{1'000'000'000};

/// A text file in memory, read line by line.
class TextFile {
 public:
  /// Reads the whole file. Throws InputError if it cannot be read or holds a zero byte (then it is no text).
  explicit TextFile(const std::string& path);

  /// The next line without its end (LF or CRLF). False at the end. A last line without a line end may have
  /// been cut: it is not given out but kept in tail().
  bool next(std::string_view& line);

  /// Number of the line given out last, from 1.
  std::uint64_t line_number() const { return line_; }
  /// What stands behind the last line end; empty for a whole file.
  std::string_view tail() const;
  /// Bytes of the whole file.
  std::uint64_t size() const { return text_.size(); }
  /// The path as it was given.
  const std::string& path() const { return path_; }
  /// "file:line", for messages.
  std::string place() const;

 private:
  std::string path_;
  std::string text_;
  std::size_t next_{};
  std::uint64_t line_{};
};

/// The start of a text in quotes, for messages: what cannot be printed is a question mark.
std::string quote(std::string_view text);

/// Cuts a line at commas (`separator` ',') or at runs of blanks (`separator` ' '). `fields` is overwritten.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields);

}  // namespace sortie::toolchain
