// SPDX-License-Identifier: BSD-3-Clause
// Numbers as text for tables, plots and files: never with the decimal comma of a locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::firmware {

/// About three significant digits, no exponent between 0.001 and 10^7: "0.042", "3.22", "184", "20000". "-"
/// for NaN, "inf" for infinity.
std::string format_short(double value);

/// `decimals` digits behind the point. "nan" and "inf" as such; zero has no sign.
std::string format_fixed(double value, int decimals);

/// The shortest text that reads back as the same number. "nan" and "inf" as such.
std::string format_exact(double value);

/// 307572 -> "307,572".
std::string group_digits(std::uint64_t value);

/// 16 hexadecimal digits.
std::string hex(std::uint64_t value);

/// Nanoseconds as seconds with nine decimals, exact: "1432235498.027976000".
std::string format_seconds(std::int64_t nanoseconds);

/// Words between blanks, tabs and line ends.
std::vector<std::string> split_words(const std::string& text);

/// Filled with blanks to `width`.
std::string pad_left(std::string_view text, std::size_t width);
std::string pad_right(std::string_view text, std::size_t width);

/// The known words that are likeliest meant by a misspelt one, at most `most`, nearest first; none that needs
/// more edits than a quarter of the word, or three. Cost: the product of the lengths for each of them.
std::vector<std::string> nearest_words(const std::string& word, const std::vector<std::string>& known,
                                       std::size_t most);

/// Cut to `width`, the last character then '~'.
std::string shorten(const std::string& text, std::size_t width);

}  // namespace sortie::firmware
