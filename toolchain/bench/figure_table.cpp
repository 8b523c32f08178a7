// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/figure_table.hpp"

#include <algorithm>
#include <ostream>

#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

// One line of the table as texts.
struct FigureRow {
  std::string what;
  std::string ours;
  std::string peer;
  std::string theirs;
  std::string ratio;
  std::string n;
  std::string goal;
  bool met{true};
};

std::string with_range(const firmware::Json& spread) {
  if (!spread.is_object() || !spread.contains("value") || !spread["value"].is_number()) return {};
  std::string text = firmware::format_short(spread["value"].get<double>());
  if (spread.contains("low") && spread["low"].is_number() && spread["high"].is_number())
    text += " (" + firmware::format_short(spread["low"].get<double>()) + " - " +
            firmware::format_short(spread["high"].get<double>()) + ")";
  return text;
}

FigureRow row_of(const firmware::Json& figure) {
  FigureRow row;
  row.what = figure.value("what", "");
  if (const std::string unit = figure.value("unit", ""); !unit.empty()) row.what += " [" + unit + "]";
  row.ours = with_range(figure.value("ours", firmware::Json::object()));
  row.peer = figure.value("peer", "");
  row.theirs = with_range(figure.value("theirs", firmware::Json::object()));
  row.ratio = with_range(figure.value("ratio", firmware::Json::object()));
  row.n = firmware::group_digits(figure.value("n", std::uint64_t{0}));
  row.goal = figure.value("goal", "");
  if (figure.contains("met") && figure["met"].is_boolean()) row.met = figure["met"].get<bool>();
  return row;
}

std::string verdict(const FigureRow& row) {
  return row.goal.empty() ? "" : row.goal + (row.met ? ": met" : ": MISSED");
}

std::string cell_text(const firmware::Json& cell) {
  if (cell.is_string()) return cell.get<std::string>();
  if (cell.is_number_integer()) {
    const auto count = cell.get<std::uint64_t>();
    const bool below = cell.get<double>() < 0;
    return (below ? "-" : "") + firmware::group_digits(below ? 0 - count : count);
  }
  return cell.is_number() ? firmware::format_short(cell.get<double>()) : "";
}

// Columns of words stand left, of numbers right.
std::vector<bool> word_columns(const firmware::Json& table) {
  std::vector<bool> words(table["columns"].size(), true);
  for (const firmware::Json& row : table["rows"]) {
    for (std::size_t i = 0; i < std::min(words.size(), row.size()); ++i)
      words[i] = words[i] && row[i].is_string();
  }
  return words;
}

TextTable text_table(const firmware::Json& table) {
  TextTable texts{{{}}, word_columns(table)};
  for (const firmware::Json& column : table["columns"]) texts.lines[0].push_back(cell_text(column));
  for (const firmware::Json& row : table["rows"]) {
    std::vector<std::string>& line = texts.lines.emplace_back();
    for (const firmware::Json& cell : row) line.push_back(cell_text(cell));
  }
  return texts;
}

template <class Each>
void for_each_of(const firmware::Json& result, const char* list, const std::string& group, const Each& each) {
  for (const firmware::Json& one : result.value(list, firmware::Json::array())) {
    if (one.value("group", "") == group) each(one);
  }
}

// The words below a group's table, one line each.
std::vector<std::string> figure_notes(const firmware::Json& result, const std::string& group) {
  std::vector<std::string> lines;
  for_each_of(result, "notes", group,
              [&](const firmware::Json& note) { lines.push_back(note.value("words", "")); });
  return lines;
}

}  // namespace

std::vector<std::string> figure_skips(const firmware::Json& result) {
  std::vector<std::string> lines;
  for (const firmware::Json& skip : result.value("skipped", firmware::Json::array()))
    lines.push_back(skip.value("what", "") + ": " + skip.value("why", ""));
  return lines;
}

std::vector<std::string> figure_groups(const firmware::Json& result) {
  std::vector<std::string> names;
  for (const char* list : {"figures", "tables"}) {
    for (const firmware::Json& one : result.value(list, firmware::Json::array())) {
      const std::string name = one.value("group", "");
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

void print_figures(std::ostream& out, const firmware::Json& result, const std::string& group, bool colour) {
  std::vector<FigureRow> rows;
  std::size_t width = 44;
  for_each_of(result, "figures", group, [&](const firmware::Json& figure) {
    rows.push_back(row_of(figure));
    width = std::max(width, rows.back().what.size() + 2);
  });
  out << "\n"
      << firmware::pad_right(group, width + 2) << firmware::pad_right("ours (range)", 25)
      << firmware::pad_right("theirs (range)", 25) << firmware::pad_right("ratio (range)", 25) << "n, goal\n";
  for (const FigureRow& row : rows) {
    out << "  " << firmware::pad_right(row.what, width) << firmware::pad_right(row.ours, 25)
        << firmware::pad_right(row.theirs, 25) << firmware::pad_right(row.ratio, 25) << row.n;
    if (!row.peer.empty()) out << "  " << row.peer;
    if (const std::string goal = verdict(row); !goal.empty())
      out << "  " << (colour && !row.met ? "\033[31m" + goal + "\033[0m" : goal);
    out << "\n";
  }
  for (const std::string& line : figure_notes(result, group)) out << "  " << line << "\n";
}

std::string figures_page(const firmware::Json& result, const std::string& group) {
  std::string text;
  for_each_of(result, "figures", group, [&](const firmware::Json& figure) {
    if (text.empty())
      text = "\n| figure | ours | peer | theirs | ratio | n | goal |\n|---|---:|---|---:|---:|---:|---|\n";
    const FigureRow row = row_of(figure);
    text += "| " + row.what + " | " + row.ours + " | " + row.peer + " | " + row.theirs + " | " + row.ratio +
            " | " + row.n + " | " + verdict(row) + " |\n";
  });
  for (const std::string& line : figure_notes(result, group)) text += "\n" + line + "\n";
  return text;
}

void print_lines(std::ostream& out, const TextTable& table) {
  std::vector<std::size_t> widths(table.words.size(), 0);
  for (const auto& line : table.lines) {
    for (std::size_t i = 0; i < std::min(widths.size(), line.size()); ++i)
      widths[i] = std::max(widths[i], line[i].size());
  }
  for (const auto& line : table.lines) {
    for (std::size_t i = 0; i < std::min(widths.size(), line.size()); ++i)
      out << "  "
          << (table.words[i] ? firmware::pad_right(line[i], widths[i])
                             : firmware::pad_left(line[i], widths[i]));
    out << "\n";
  }
}

std::string markdown(const TextTable& table) {
  std::string rule = "|";
  for (const bool words : table.words) rule += words ? "---|" : "---:|";
  std::string text;
  for (const auto& line : table.lines) {
    text += "|";
    for (const std::string& cell : line) text += " " + cell + " |";
    text += "\n";
    if (&line == &table.lines.front()) text += rule + "\n";
  }
  return text;
}

void print_tables(std::ostream& out, const firmware::Json& result, const std::string& group) {
  for_each_of(result, "tables", group, [&](const firmware::Json& table) {
    out << "\n";
    print_lines(out, text_table(table));
  });
}

std::string tables_page(const firmware::Json& result, const std::string& group) {
  std::string text;
  for_each_of(result, "tables", group,
              [&](const firmware::Json& table) { text += "\n" + markdown(text_table(table)); });
  return text;
}

}  // namespace sortie::toolchain
