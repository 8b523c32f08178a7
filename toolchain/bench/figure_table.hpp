// SPDX-License-Identifier: BSD-3-Clause
// Figures beside a peer's as benchmark programs report them, and any table of texts: as text and as Markdown.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/scene/json.hpp"

namespace sortie::toolchain {

/// A table of texts: the head, then the lines. Columns of words stand left, of numbers right.
struct TextTable {
  std::vector<std::vector<std::string>> lines;
  std::vector<bool> words;  ///< a column each
};

/// As text, each column as wide as it must be; and as Markdown.
void print_lines(std::ostream& out, const TextTable& table);
std::string markdown(const TextTable& table);

/// Groups of figures and tables, in the order in which they come.
std::vector<std::string> figure_groups(const firmware::Json& result);

/// What could not be measured and why, one line each.
std::vector<std::string> figure_skips(const firmware::Json& result);

/// A group's figures: ours, theirs, ratio, each with its range over the rounds, and the goals; then its
/// notes.
void print_figures(std::ostream& out, const firmware::Json& result, const std::string& group, bool colour);

/// The same as a Markdown table with the notes below it; empty where the group has neither.
std::string figures_page(const firmware::Json& result, const std::string& group);

/// A group's plain tables (columns and rows of texts and numbers) as text and as Markdown.
void print_tables(std::ostream& out, const firmware::Json& result, const std::string& group);
std::string tables_page(const firmware::Json& result, const std::string& group);

}  // namespace sortie::toolchain
